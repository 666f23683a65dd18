/*
 * For fuzz targets: a server on sockets of its own, with a stream "test" and its scripted mesher
 * (tests/unit/server_fixture.h), all of it in one thread that is turned by hand. It lives from one
 * input to the next, and is made anew when one has ended it.
 */
#ifndef DX_SERVER_RIG_H
#define DX_SERVER_RIG_H

#include "tests/unit/server_client.h"

#include <sys/un.h>
#include <systemd/sd-event.h>

#include "daemon/server_priv.h"

#define MUST(condition)                                                                            \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                \
            abort();                                                                               \
        }                                                                                          \
    } while (0)

struct server_rig {
    struct fixture fx;
    struct mesher mesher;
    bool is_up, has_ended; /* ended: its loop runs no more */
};

static struct server_rig rig;

static inline void rig_kick(void *ctx)
{
    (void)ctx; /* each turn asks the mesher */
}

/* A journal that nobody reads: soon full, and then the lines are gone. */
static inline void rig_journal(const char *path)
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);

    MUST(fd >= 0 && strlen(path) < sizeof(addr.sun_path));
    strcpy(addr.sun_path, path);
    MUST(bind(fd, (struct sockaddr *)&addr, sizeof(addr)) == 0);
    dx_log_to_journal(path);
    dx_log_set_level(LOG_DEBUG);
}

/* Once: the folder of the sockets. */
static inline void rig_init(void)
{
    static char log_path[108];
    struct fixture *fx = &rig.fx;

    strcpy(fx->dir, "/tmp/dexeld-fuzz-XXXXXX");
    MUST(mkdtemp(fx->dir));
    snprintf(fx->mesh, sizeof(fx->mesh), "%s/mesh.sock", fx->dir);
    snprintf(fx->control, sizeof(fx->control), "%s/control.sock", fx->dir);
    snprintf(log_path, sizeof(log_path), "%s/log.sock", fx->dir);
    rig_journal(log_path);
}

static inline void rig_down(void)
{
    dx_server_free(rig.fx.server);
    dx_feed_free(rig.fx.feed);
    rig.fx.server = NULL;
    rig.fx.feed = NULL;
    rig.is_up = rig.has_ended = false;
}

static inline void rig_clean(void)
{
    char path[108];

    rig_down();
    snprintf(path, sizeof(path), "%s/log.sock", rig.fx.dir);
    unlink(path);
    rmdir(rig.fx.dir);
}

/* Publishes what is new and what is asked for; handles events until there is none. */
static inline void rig_turn(void)
{
    bool moved;
    int r = 0;

    do {
        moved = false;
        while (!rig.has_ended && (r = sd_event_run(rig.fx.server->event, 0)) > 0)
            moved = true;
        rig.has_ended = rig.has_ended || r < 0;
        while (!rig.has_ended && mesher_publish(&rig.mesher))
            moved = true;
    } while (moved && !rig.has_ended);
}

/* Waits a second at most for an event; false: none came. */
static inline bool rig_wait(void)
{
    int r = rig.has_ended ? -1 : sd_event_run(rig.fx.server->event, 1000000);

    rig.has_ended = rig.has_ended || r < 0;
    return r > 0;
}

static inline void rig_add_stream(const struct fixture_options *options)
{
    struct fixture *fx = &rig.fx;

    fx->body_len = 300;
    fx->attr_bytes = options->attr_bytes;
    fx->normals = options->normals;
    fx->lossless = options->lossless;
    fx->grid = options->grid;
    fx->target = 3;
    MUST(dx_feed_new_sized(&fx->feed, MAX_TILES, 1024, 2048, 64, -1, rig_kick, NULL) == 0);
    MUST(dx_server_add_stream(
             fx->server, &(struct dx_server_stream_options){.name = "test",
                                                            .feed = fx->feed,
                                                            .counters = &fx->counters,
                                                            .lossless = options->lossless}) == 0);
    rig.mesher = (struct mesher){.fx = fx};
    mesher_announce(&rig.mesher);
}

/* True: it is a new one, to which the target may add streams. */
static inline bool rig_up(const struct fixture_options *options)
{
    struct dx_server_options o = options->server;
    struct dx_err err;

    if (rig.is_up && !rig.has_ended)
        return false;
    if (rig.is_up)
        rig_down();
    if (!*rig.fx.dir) {
        rig_init();
        atexit(rig_clean);
    }
    o.mesh_path = rig.fx.mesh;
    o.control_path = rig.fx.control;
    MUST(dx_server_new(&rig.fx.server, &o, &err) == 0);
    rig_add_stream(options);
    rig.is_up = true;
    rig_turn();
    return true;
}

#endif
