/* The encoder: see encoder.h. */
#include "daemon/encoder.h"

#include <errno.h>
#include <stdlib.h>

#define WINDOW 16 /* tiles encoded at a time: enough for the pool, small enough for the cache */

/* A tile on its way to the feed: its chunk in each encoding that wants it (len 0: not wanted). */
struct encode_job {
    uint32_t tile;
    size_t len[DX_N_ENCODINGS];
    uint8_t *body[DX_N_ENCODINGS];
};

struct encode_scratch {
    struct dx_tile tile;
    struct dx_tile_mesh mesh;
};

struct dx_encoder {
    struct dx_pool *pool;
    const struct dx_terrain *terrain; /* of the call under way */
    struct encode_job job[WINDOW];
    struct encode_scratch *scratch; /* one a thread */
};

int dx_encoder_new(struct dx_encoder **out, struct dx_pool *pool)
{
    struct dx_encoder *e = calloc(1, sizeof(*e));

    if (!e)
        return -ENOMEM;
    e->pool = pool;
    e->scratch = calloc(dx_pool_threads(pool), sizeof(*e->scratch));
    if (!e->scratch)
        goto err_encoder;
    for (int k = 0; k < WINDOW; k++)
        for (unsigned n = 0; n < DX_N_ENCODINGS; n++) {
            e->job[k].body[n] = malloc(dx_chunk_max_len((enum dx_encoding)n));
            if (!e->job[k].body[n])
                goto err_encoder;
        }
    *out = e;
    return 0;

err_encoder:
    dx_encoder_free(e);
    return -ENOMEM;
}

void dx_encoder_free(struct dx_encoder *e)
{
    if (!e)
        return;
    for (int k = 0; k < WINDOW; k++)
        for (int n = 0; n < DX_N_ENCODINGS; n++)
            free(e->job[k].body[n]);
    free(e->scratch);
    free(e);
}

/* Runs on the pool: the chunks of one tile. */
static void encode_tile(void *ctx, uint32_t task, unsigned thread)
{
    struct dx_encoder *e = ctx;
    struct encode_job *job = &e->job[task];
    struct encode_scratch *s = &e->scratch[thread];
    bool some = dx_terrain_tile(e->terrain, job->tile, &s->tile);

    for (unsigned n = 0; n < DX_N_ENCODINGS; n++) {
        if (!job->len[n])
            continue;
        if (!some) {
            job->len[n] =
                dx_chunk_put_empty(job->body[n], (enum dx_encoding)n, s->tile.row, s->tile.col);
        } else if (n == DX_ENCODING_F32) {
            dx_tile_mesh_build(&s->mesh, &s->tile, dx_terrain_tiling(e->terrain),
                               dx_terrain_geometry(e->terrain));
            job->len[n] = dx_chunk_put_f32(job->body[n], &s->mesh);
        } else if (n == DX_ENCODING_Q16) {
            job->len[n] = dx_chunk_put_q16(job->body[n], &s->tile);
        } else {
            job->len[n] = dx_chunk_put_delta(job->body[n], &s->tile);
        }
        if (dx_terrain_params(e->terrain)->smooth)
            dx_chunk_set_smoothed(job->body[n]);
    }
}

/* Encodes the first n jobs and adds them to the open epoch. False: short of chunks. */
static bool flush_jobs(struct dx_encoder *e, struct dx_feed *feed, uint32_t n_jobs)
{
    dx_pool_run(e->pool, n_jobs, encode_tile, e);
    for (uint32_t k = 0; k < n_jobs; k++)
        for (unsigned n = 0; n < DX_N_ENCODINGS; n++)
            if (e->job[k].len[n] && !dx_feed_add(feed, e->job[k].tile, (enum dx_encoding)n,
                                                 e->job[k].body[n], e->job[k].len[n]))
                return false;
    return true;
}

bool dx_encoder_add(struct dx_encoder *e, struct dx_feed *feed, const struct dx_terrain *terrain,
                    uint64_t *const pending[DX_N_ENCODINGS])
{
    uint32_t n_tiles = dx_tiling_n_tiles(dx_terrain_tiling(terrain)), n_jobs = 0;

    e->terrain = terrain;
    for (uint32_t t = 0; t < n_tiles; t++) {
        struct encode_job *job = &e->job[n_jobs];
        bool any = false;

        for (int n = 0; n < DX_N_ENCODINGS; n++) {
            job->len[n] = pending[n][t / 64] >> (t % 64) & 1;
            any |= job->len[n];
        }
        if (!any)
            continue;
        job->tile = t;
        if (++n_jobs == WINDOW) {
            if (!flush_jobs(e, feed, n_jobs))
                return false;
            n_jobs = 0;
        }
    }
    return n_jobs == 0 || flush_jobs(e, feed, n_jobs);
}
