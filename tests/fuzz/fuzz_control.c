/*
 * What anybody may send to the control socket, to a server with a stream of a device, one that is
 * recorded and one that replays. Every line is answered with one line that is a JSON object, or the
 * connection is ended with one that says why.
 *
 * Input: a byte of how (1: a subscriber is there; the rest: bytes a write, 0: all at once), bytes.
 */
#include "tests/fuzz/server_rig.h"

#include "daemon/control.h"
#include "daemon/control_config.h"
#include "daemon/player.h"
#include "daemon/recorder.h"
#include "daemon/reload_report.h"
#include "drivers/file/file.h"
#include "drivers/synth/synth.h"

#include <fcntl.h>
#include <jansson.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

/* ---- the drivers, in place of those of the build: their devices would differ by machine ---------
 */

static int probe(void (*found)(void *ctx, const struct dx_device_found *device), void *ctx,
                 struct dx_err *err)
{
    found(ctx, &(struct dx_device_found){"a scanner", "/dev/null", "S1", "usb-1", "serial: S1", 0});
    found(ctx, &(struct dx_device_found){"\x1b[1mone", "/dev/null", "\xff", "", "", -EACCES});
    return dx_err_set(err, -EIO, "one that does not answer");
}

static const struct dx_driver attached = {.name = "attached", .probe = probe};

const struct dx_driver *const dx_drivers[] = {&attached, &dx_synth_driver, NULL};

const struct dx_driver *dx_driver_find(const char *name)
{
    return strcmp(name, "synthetic") ? NULL : &dx_synth_driver;
}

/* ---- a recording, and what replays it -----------------------------------------------------------
 */

#define YAML "streams: [{name: box, synthetic: {scene: moving-box, size: 8x8, frames: 4}}]\n"

static struct dx_feed *feed[2];
static struct dx_counters counters[2];
static struct dx_recorder *recorder;
static struct dx_device *player;

static char recording_path[108];

static int create_file(void *ctx, struct dx_mcap_sink *sink, const char **path, uint64_t unix_ns)
{
    int *fd = ctx;

    (void)unix_ns;
    *fd = open(recording_path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    *path = recording_path;
    *sink = dx_mcap_sink_fd(*fd);
    return *fd < 0 ? -errno : 0;
}

static int sync_file(void *ctx)
{
    (void)ctx;
    return 0;
}

static void close_file(void *ctx)
{
    close(*(const int *)ctx);
}

static int recording_fd;

static struct dx_recorder *new_recorder(void)
{
    const struct dx_recorder_config c = {
        .name = "box",
        .driver = "synthetic",
        .yaml = YAML,
        .yaml_len = strlen(YAML),
        .store = {&recording_fd, create_file, sync_file, close_file},
        .ring_len = 1 << 16,
        .start = true};
    struct dx_recorder *r;
    struct dx_err err;

    MUST(dx_recorder_new(&r, &c, &err) == 0);
    return r;
}

static void record(void)
{
    struct dx_recorder *r = new_recorder();
    struct dx_config config;
    struct dx_device *dev;
    struct dx_block block;
    struct dx_err err;

    MUST(dx_config_parse(&config, "yaml", YAML, strlen(YAML), &err) == 0);
    MUST(dx_synth_driver.open(&dev, &config.streams[0].source, &err) == 0);
    MUST(dx_synth_driver.start(dev, &err) == 0);
    while (dx_synth_driver.read(dev, &block, &err) == 0)
        dx_recorder_feed(r, &block, true);
    dx_recorder_stop(r, true);
    dx_recorder_run(r);
    dx_recorder_free(r);
    dx_synth_driver.close(dev);
    dx_config_fini(&config);
}

static void open_player(void)
{
    const struct dx_file_config c = {.path = recording_path, .rate = 1};
    struct dx_err err;

    snprintf(recording_path, sizeof(recording_path), "%s/recording.mcap", rig.fx.dir);
    record();
    MUST(dx_player_driver.open(&player, &c, &err) == 0);
    MUST(dx_player_driver.start(player, &err) == 0);
    unlink(recording_path);
}

/* ---- the server -------------------------------------------------------------------------------
 */

static uint64_t n_reloads, n_reloaded;

static uint64_t reload(void *ctx)
{
    (void)ctx;
    return ++n_reloads;
}

static char *config(void *ctx)
{
    (void)ctx;
    return strdup("socket: /run/\xff\n");
}

/* Every other one is refused. */
static void end_reloads(void)
{
    struct dx_reload_report report = {
        .file = "/etc/\xff.yaml",
        .n_streams = 1,
        .stream = {{.name = "test", .did = DX_RELOAD_CHANGED}},
        .n_fixed = 1,
        .fixed = {"socket"},
    };

    while (n_reloaded < n_reloads && !rig.has_ended) {
        report.is_refused = ++n_reloaded % 2;
        snprintf(report.err.text, sizeof(report.err.text), "%s", n_reloaded % 3 ? "\xff" : "");
        dx_control_reloaded(rig.fx.server, n_reloaded, &report);
    }
}

static void free_all(void)
{
    rig_down();
    for (int k = 0; k < 2; k++)
        dx_feed_free(feed[k]);
    dx_recorder_free(recorder);
    dx_player_driver.close(player);
}

static void up(void)
{
    static const struct fixture_options options = {
        .server = {.reload = reload, .config = config, .limits.max_requests = UINT32_MAX}};
    static const char *const names[2] = {"recorded", "r\xc3\xb6hre"};

    if (!rig_up(&options))
        return;
    if (!recorder) {
        open_player();
        recorder = new_recorder();
        atexit(free_all);
    }
    for (int k = 0; k < 2; k++) {
        dx_feed_free(feed[k]);
        MUST(dx_feed_new_sized(&feed[k], 4, 16, 512, 64, -1, rig_kick, NULL) == 0);
        MUST(dx_server_add_stream(rig.fx.server, &(struct dx_server_stream_options){
                                                     .name = names[k],
                                                     .feed = feed[k],
                                                     .counters = &counters[k],
                                                     .recorder = k == 0 ? recorder : NULL,
                                                     .player = k == 1 ? player : NULL}) == 0);
    }
}

/* ---- the conversation -------------------------------------------------------------------------
 */

struct talk {
    int fd;
    bool has_ended, is_turned_away;
    uint32_t n_asked, n_answers;
    size_t len; /* of the answer that is not whole */
    char said[1 << 20];
};

static void check_answer(struct talk *t, size_t len)
{
    json_t *answer = json_loadb(t->said, len, 0, NULL);
    const char *error = json_string_value(json_object_get(answer, "error"));

    MUST(json_is_object(answer));
    if (error &&
        (!strncmp(error, "too long a request", 18) || !strncmp(error, "found a control byte", 20)))
        t->is_turned_away = true;
    else
        t->n_answers++;
    json_decref(answer);
}

static void hear(struct talk *t)
{
    ssize_t n;
    char *end;

    while (!t->has_ended) {
        n = recv(t->fd, t->said + t->len, sizeof(t->said) - t->len, MSG_DONTWAIT);
        if (n < 0 && errno == EAGAIN)
            break;
        t->has_ended = n <= 0;
        t->len += n > 0 ? (size_t)n : 0;
        while ((end = memchr(t->said, '\n', t->len))) {
            size_t len = (size_t)(end - t->said) + 1;

            MUST(!t->is_turned_away);
            check_answer(t, len);
            t->len -= len;
            memmove(t->said, t->said + len, t->len);
        }
        MUST(t->len < sizeof(t->said));
    }
}

static void turn(struct talk *t)
{
    uint32_t before;

    do {
        before = t->n_answers;
        rig_turn();
        end_reloads();
        hear(t);
    } while (t->n_answers > before);
}

static void say(struct talk *t, const uint8_t *bytes, size_t len, size_t step)
{
    while (len && !t->has_ended) {
        size_t n = len < step ? len : step;
        ssize_t sent = send(t->fd, bytes, n, MSG_NOSIGNAL | MSG_DONTWAIT);

        if (sent < 0)
            break;
        for (ssize_t k = 0; k < sent; k++)
            t->n_asked += bytes[k] == '\n';
        bytes += sent;
        len -= (size_t)sent;
        turn(t);
    }
}

/* Some answers come from another thread. */
static void await_answers(struct talk *t)
{
    for (int k = 0; k < 20 && t->n_answers < t->n_asked; k++) {
        turn(t);
        if (t->has_ended || rig.has_ended || t->n_answers == t->n_asked)
            break;
        rig_wait();
    }
    MUST(t->n_answers <= t->n_asked);
    MUST(t->n_answers == t->n_asked || t->is_turned_away || rig.has_ended);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    static struct talk t;
    struct client *c = NULL;

    if (len < 1)
        return 0;
    up();
    t.fd = client_socket(rig.fx.control, 0);
    t.has_ended = t.is_turned_away = false;
    t.n_asked = t.n_answers = 0;
    t.len = 0;
    rig.fx.server->n_connections = 0; /* its number is 1 */
    if (bytes[0] & 1)
        c = client_start(&rig.fx, &(struct dx_msg_subscribe){.stream = "test"});
    rig_turn();
    say(&t, bytes + 1, len - 1, bytes[0] / 2 ? bytes[0] / 2 : len);
    await_answers(&t);
    close(t.fd);
    if (c)
        client_close(c);
    rig_turn();
    return 0;
}
