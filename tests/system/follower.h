/*
 * A subscriber that a test drives: it keeps a hash of each tile it holds, and for each commit the
 * digest of all of them, so that what two subscribers held at one epoch or frame can be compared,
 * whatever the encodings. Also what the tests of the service share: waiting, and saying why not.
 * One thread each.
 */
#ifndef DX_FOLLOWER_H
#define DX_FOLLOWER_H

#include <poll.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "client/dexel.h"
#include "core/base/hash.h"

#define FOLLOWER_HISTORY    2048
#define FOLLOWER_SILENCE_MS 300000 /* guards against hanging; nothing is measured by it */

struct follower_commit {
    struct dexel_commit commit; /* epoch 0: none */
    uint64_t digest;
};

struct follower {
    const char *name;
    struct dexel *d;
    enum dexel_mode mode;
    bool raw;       /* tiles are counted, not decoded: no digests */
    bool reconnect; /* it outlives the service */
    bool may_fail;  /* an error ends it (`failed`), not the test */
    uint64_t *tile; /* hash of each tile held; 0: empty */
    uint32_t n_tiles, tile_cols;
    uint64_t digest;
    struct follower_commit history[FOLLOWER_HISTORY]; /* by epoch */
    struct dexel_commit last;
    uint64_t first_frame, first_dropped; /* of the first commit after the snapshot */
    unsigned n_commits, n_partial, n_resets;
    unsigned n_missed;      /* epochs */
    enum dexel_state state; /* told last */
    unsigned n_gone;        /* times that it was DEXEL_GONE */
    bool ended, failed;
};

__attribute__((format(printf, 1, 2), noreturn)) static inline void die(const char *fmt, ...)
{
    va_list ap;

    va_start(ap, fmt);
    vprintf(fmt, ap);
    va_end(ap);
    putchar('\n');
    exit(1);
}

static inline int follower_on_stream(void *user, const struct dexel_stream *s)
{
    struct follower *f = user;

    free(f->tile);
    f->n_tiles = s->tile_rows * s->tile_cols;
    f->tile_cols = s->tile_cols;
    f->tile = calloc(f->n_tiles, sizeof(*f->tile));
    f->digest = 0;
    return f->tile ? 0 : 1;
}

static inline int follower_on_reset(void *user, const char *reason)
{
    struct follower *f = user;

    f->n_resets++;
    printf("%s: reset: %s\n", f->name, reason);
    return 0;
}

static inline int follower_on_tile(void *user, const struct dexel_tile *t)
{
    struct follower *f = user;
    uint32_t number = t->row * f->tile_cols + t->col;
    uint64_t h = 0;

    if (t->n_triangles) {
        h = dx_hash_u64(number, (uint64_t)t->n_vertices << 32 | t->n_triangles);
        h = dx_hash(h, t->xyz, 12 * (size_t)t->n_vertices);
        h = dx_hash(h, t->index, 6 * (size_t)t->n_triangles);
        h = dx_hash(h, t->dexel, 4 * (size_t)t->n_vertices);
    }
    f->digest ^= f->tile[number] ^ h;
    f->tile[number] = h;
    return 0;
}

static inline int follower_on_commit(void *user, const struct dexel_commit *c)
{
    struct follower *f = user;
    /* a snapshot is longer than a socket holds: what came meanwhile is one batch after it */
    bool counts = f->n_commits && !c->snapshot && !f->last.snapshot;
    unsigned missed = counts ? (unsigned)(c->epoch - f->last.epoch - 1) : 0;

    if (f->n_commits == 1) {
        f->first_frame = c->frame;
        f->first_dropped = c->n_dropped;
    }
    f->n_missed += missed;
    f->n_commits++;
    f->n_partial += c->partial != 0;
    f->last = *c;
    f->history[c->epoch % FOLLOWER_HISTORY] = (struct follower_commit){*c, f->digest};
    return 0;
}

static inline int follower_on_state(void *user, enum dexel_state state, const char *reason)
{
    struct follower *f = user;

    (void)reason;
    f->state = state;
    f->n_gone += state == DEXEL_GONE;
    f->ended = state == DEXEL_ENDED;
    return 0;
}

/* `f` is zeroed but for `name`, `mode`, `raw`, `reconnect` and `may_fail`. */
static inline void follower_open(struct follower *f, const char *socket, const char *stream,
                                 enum dexel_encoding encoding)
{
    const struct dexel_callbacks callbacks = {.stream = follower_on_stream,
                                              .reset = follower_on_reset,
                                              .tile = f->raw ? NULL : follower_on_tile,
                                              .commit = follower_on_commit,
                                              .state = follower_on_state};
    const struct dexel_options options = {.socket = socket,
                                          .stream = stream,
                                          .encoding = encoding,
                                          .mode = f->mode,
                                          .reconnect = f->reconnect};

    if (dexel_open(&f->d, &options, &callbacks, f) < 0)
        die("%s: %s", f->name, dexel_error(f->d));
}

static inline void follower_close(struct follower *f)
{
    dexel_close(f->d);
    free(f->tile);
    f->d = NULL;
    f->tile = NULL;
}

/* What it held at an epoch, or NULL: it never had it. */
static inline const struct follower_commit *follower_at(const struct follower *f, uint64_t epoch)
{
    const struct follower_commit *c = &f->history[epoch % FOLLOWER_HISTORY];

    return epoch && c->commit.epoch == epoch ? c : NULL;
}

/* Handles what came for it. */
static inline void follower_turn(struct follower *f)
{
    f->failed = dexel_dispatch(f->d) < 0;
    if (f->failed && !f->may_fail)
        die("%s: %s", f->name, dexel_error(f->d));
}

/* Waits until something came for one of them, and handles that. `also` (or -1) is looked at, too:
 * true when it is readable or at its end. */
static inline bool followers_turn(struct follower *const *f, unsigned n, int also)
{
    struct pollfd p[32];

    if (n >= sizeof(p) / sizeof(p[0]))
        die("too many followers");
    for (unsigned k = 0; k < n; k++)
        p[k] = (struct pollfd){f[k]->failed ? -1 : dexel_fd(f[k]->d), dexel_events(f[k]->d), 0};
    p[n] = (struct pollfd){also, POLLIN, 0};
    if (poll(p, n + 1, FOLLOWER_SILENCE_MS) <= 0)
        die("%s: nothing from the service", f[0]->name);
    for (unsigned k = 0; k < n; k++)
        if (p[k].revents)
            follower_turn(f[k]);
    return p[n].revents != 0;
}

/* Resident memory of a process in KiB. */
static inline long rss_kib(long pid)
{
    char path[64], line[256];
    long kib = -1;
    FILE *f;

    snprintf(path, sizeof(path), "/proc/%ld/status", pid);
    f = fopen(path, "r");
    if (!f)
        die("%s cannot be read: the service is gone", path);
    while (kib < 0 && fgets(line, sizeof(line), f))
        if (strncmp(line, "VmRSS:", 6) == 0)
            kib = strtol(line + 6, NULL, 10);
    fclose(f);
    return kib;
}

/* Built with a sanitizer or to count lines, as the service then is, memory and speed are the
 * build's. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || defined(COUNTS_LINES)
#define SANITIZED true
#else
#define SANITIZED false
#endif

#endif
