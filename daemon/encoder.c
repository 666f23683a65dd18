/* The encoder: see encoder.h. */
#include "daemon/encoder.h"

#include <errno.h>
#include <stdlib.h>

#define WINDOW    16 /* tiles encoded at a time: enough for the pool, small enough for the cache */
#define FEW_BYTES (256u << 10) /* are copied sooner than another thread wakes */

/* A tile on its way to the feed: its chunk in each form that wants it (len 0: not wanted). */
struct encode_job {
    uint32_t tile;
    size_t len[DX_N_FORMS];
    uint8_t *body[DX_N_FORMS];
    uint32_t chunk[DX_N_FORMS]; /* where it goes */
};

struct encode_scratch {
    struct dx_tile tile;
    struct dx_tile_mesh mesh, cut;
    struct dx_lod_scratch *lod;
};

struct dx_encoder {
    struct dx_pool *pool;
    struct dx_encoder_source source; /* of the call under way, and where its chunks go */
    struct dx_feed *feed;
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
    for (unsigned k = 0; k < dx_pool_threads(pool); k++) {
        e->scratch[k].lod = dx_lod_scratch_new();
        if (!e->scratch[k].lod)
            goto err_encoder;
    }
    for (int k = 0; k < WINDOW; k++)
        for (unsigned n = 0; n < DX_N_FORMS; n++) {
            e->job[k].body[n] = malloc(dx_chunk_max_len(dx_form_encoding(n)));
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
        for (int n = 0; n < DX_N_FORMS; n++)
            free(e->job[k].body[n]);
    for (unsigned k = 0; e->scratch && k < dx_pool_threads(e->pool); k++)
        dx_lod_scratch_free(e->scratch[k].lod);
    free(e->scratch);
    free(e);
}

/* The tile in one form; levels of detail are cut from its mesh. */
static size_t encode_form(const struct dx_encoder *e, struct encode_scratch *s, unsigned form,
                          uint8_t *body)
{
    const struct dx_encoder_source *from = &e->source;

    switch (form) {
    case DX_ENCODING_F32:
        return dx_chunk_put_f32(body, &s->tile, dx_terrain_tiling(from->terrain),
                                dx_terrain_geometry(from->terrain));
    case DX_ENCODING_Q16:
        return dx_chunk_put_q16(body, &s->tile);
    case DX_ENCODING_DELTA:
        return dx_chunk_put_delta(body, &s->tile);
    default:
        dx_lod_mesh(&s->cut, from->lod, from->level[form - DX_N_ENCODINGS], &s->tile, &s->mesh,
                    s->lod);
        return dx_chunk_put_mesh(body, &s->cut);
    }
}

static bool wants_mesh(const struct encode_job *job)
{
    for (unsigned n = DX_N_ENCODINGS; n < DX_N_FORMS; n++)
        if (job->len[n])
            return true;
    return false;
}

/* Runs on the pool: the chunks of one tile. */
static void encode_tile(void *ctx, uint32_t task, unsigned thread)
{
    struct dx_encoder *e = ctx;
    struct encode_job *job = &e->job[task];
    struct encode_scratch *s = &e->scratch[thread];
    const struct dx_terrain *terrain = e->source.terrain;
    bool some = dx_terrain_tile(terrain, job->tile, &s->tile);

    if (some && wants_mesh(job))
        dx_tile_mesh_build(&s->mesh, &s->tile, dx_terrain_tiling(terrain),
                           dx_terrain_geometry(terrain));
    for (unsigned n = 0; n < DX_N_FORMS; n++) {
        if (!job->len[n])
            continue;
        job->len[n] =
            some ? encode_form(e, s, n, job->body[n])
                 : dx_chunk_put_empty(job->body[n], dx_form_encoding(n), s->tile.row, s->tile.col);
        if (dx_terrain_params(terrain)->smooth)
            dx_chunk_set_smoothed(job->body[n]);
    }
}

/* Runs on the pool: the chunks of one tile to where they go. */
static void fill_tile(void *ctx, uint32_t task, unsigned thread)
{
    const struct dx_encoder *e = ctx;
    const struct encode_job *job = &e->job[task];

    (void)thread;
    for (unsigned n = 0; n < DX_N_FORMS; n++)
        if (job->len[n])
            dx_feed_fill(e->feed, job->chunk[n], job->body[n]);
}

/* Encodes the first n jobs and adds them to the open epoch, in their order. False: short of chunks.
 */
static bool flush_jobs(struct dx_encoder *e, uint32_t n_jobs)
{
    size_t n_bytes = 0;

    dx_pool_run_tiles(e->pool, n_jobs, encode_tile, e);
    for (uint32_t k = 0; k < n_jobs; k++) {
        struct encode_job *job = &e->job[k];

        for (unsigned n = 0; n < DX_N_FORMS; n++) {
            if (job->len[n] && !dx_feed_add(e->feed, job->tile, n, job->len[n], &job->chunk[n]))
                return false;
            n_bytes += job->len[n];
        }
    }
    dx_pool_run(n_bytes > FEW_BYTES ? e->pool : NULL, n_jobs, fill_tile, e);
    return true;
}

bool dx_encoder_add(struct dx_encoder *e, struct dx_feed *feed,
                    const struct dx_encoder_source *source, uint64_t *const pending[DX_N_FORMS])
{
    uint32_t n_tiles = dx_tiling_n_tiles(dx_terrain_tiling(source->terrain)), n_jobs = 0;

    e->source = *source;
    e->feed = feed;
    for (uint32_t t = 0; t < n_tiles; t++) {
        struct encode_job *job = &e->job[n_jobs];
        bool any = false;

        for (int n = 0; n < DX_N_FORMS; n++) {
            job->len[n] = pending[n][t / 64] >> (t % 64) & 1;
            any |= job->len[n];
        }
        if (!any)
            continue;
        job->tile = t;
        if (++n_jobs == WINDOW) {
            if (!flush_jobs(e, n_jobs))
                return false;
            n_jobs = 0;
        }
    }
    return n_jobs == 0 || flush_jobs(e, n_jobs);
}
