/*
 * Many subscribers of one service in one thread: what comes to them, how late, and what they miss.
 * Tiles are counted, and not decoded unless asked: a machine that measures its own service should
 * not be busy with something else.
 */
#ifndef DX_BENCH_SWARM_H
#define DX_BENCH_SWARM_H

#include "client/dexel.h"
#include "core/base/err.h"

#include <stdbool.h>

#define DX_SWARM_MAX 1000

struct dx_swarm_options {
    struct dexel_options subscribe;
    uint32_t n_subscribers; /* up to DX_SWARM_MAX */
    bool decode;
};

/* Of all subscribers, while it was measured. */
struct dx_swarm_figures {
    double seconds;
    uint64_t n_commits, n_tiles, n_bytes; /* bytes of TILE bodies */
    uint64_t n_missed, n_resets;          /* epochs that did not come; everything begun anew */
    uint64_t n_dropped;                   /* frames that the mesher skipped */
    uint32_t grid_tiles;
    double p50_ms, p99_ms, max_ms; /* of the stamp of a frame until its COMMIT is here */
};

struct dx_swarm;

/* Connects, and returns when all have a whole mesh. Errors: -errno with text. */
int dx_swarm_open(struct dx_swarm **out, const struct dx_swarm_options *options,
                  struct dx_err *err);
void dx_swarm_close(struct dx_swarm *s);

/* Receives for so long. Errors: -errno with text; -ENODATA: no COMMIT came. */
int dx_swarm_run(struct dx_swarm *s, double seconds, struct dx_swarm_figures *figures,
                 struct dx_err *err);

#endif
