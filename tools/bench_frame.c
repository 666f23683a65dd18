/* Frames, encoding and memory for the benchmarks of a frame: see bench_frame.h. */
#include "tools/bench_frame.h"

#include "core/base/bytes.h"
#include "core/grid/marks.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* ---- frames -----------------------------------------------------------------------------------
 */

#define STRIP 64 /* columns of a task */

struct cast {
    struct dx_bench_frames *frames;
    struct dx_scene_config scene[2];
    uint32_t n_strips;
};

static void cast_strip(void *ctx, uint32_t task, unsigned thread)
{
    struct cast *c = ctx;
    uint32_t frame = task / c->n_strips, col0 = task % c->n_strips * STRIP;
    struct dx_plane *plane = &c->frames->plane[frame];
    uint32_t left = plane->width - col0;

    (void)thread;
    dx_scene_cast(plane, c->frames->geometry, &c->scene[frame], 0, col0,
                  left < STRIP ? left : STRIP);
}

static int cast_frames(struct dx_bench_frames *f, const struct dx_scene_config *scene)
{
    struct cast c = {f, {*scene, *scene}, (scene->width + STRIP - 1) / STRIP};
    struct dx_pool *pool;
    int r = dx_pool_new(&pool, 0);

    if (r < 0)
        return r;
    c.scene[1].seed++;
    dx_pool_run(pool, 2 * c.n_strips, cast_strip, &c);
    dx_pool_free(pool);
    return 0;
}

int dx_bench_frames_init(struct dx_bench_frames *f, const struct dx_bench_args *a,
                         struct dx_bench_size size)
{
    struct dx_scene_config scene = a->scene;
    int r;

    *f = (struct dx_bench_frames){0};
    scene.width = size.width;
    scene.height = size.height;
    r = dx_scene_geometry(&f->geometry, &scene);
    for (int k = 0; r == 0 && k < 2; k++)
        r = dx_plane_init_for(&f->plane[k], f->geometry, 0);
    return r == 0 ? cast_frames(f, &scene) : r;
}

void dx_bench_frames_fini(struct dx_bench_frames *f)
{
    dx_plane_fini(&f->plane[0]);
    dx_plane_fini(&f->plane[1]);
    dx_geometry_unref(f->geometry);
}

/* ---- encoding ---------------------------------------------------------------------------------
 */

struct scratch {
    struct dx_tile tile;
    uint8_t *body;
    struct dx_bench_encoded done;
};

struct dx_bench_encoder {
    unsigned n_threads;
    struct scratch *scratch;
    uint32_t *tile; /* of each job */
    /* of the call under way */
    const struct dx_terrain *terrain;
    enum dx_encoding encoding;
};

int dx_bench_encoder_new(struct dx_bench_encoder **out, const struct dx_tiling *tiling,
                         unsigned n_threads)
{
    struct dx_bench_encoder *e = calloc(1, sizeof(*e));

    if (!e)
        return -ENOMEM;
    e->n_threads = n_threads;
    e->scratch = calloc(n_threads, sizeof(*e->scratch));
    e->tile = calloc(dx_tiling_n_tiles(tiling), sizeof(*e->tile));
    for (unsigned k = 0; e->scratch && k < n_threads; k++) {
        e->scratch[k].body = malloc(dx_chunk_max_len(DX_ENCODING_F32));
        if (!e->scratch[k].body)
            goto err_encoder;
    }
    if (!e->scratch || !e->tile)
        goto err_encoder;
    *out = e;
    return 0;

err_encoder:
    dx_bench_encoder_free(e);
    return -ENOMEM;
}

void dx_bench_encoder_free(struct dx_bench_encoder *e)
{
    if (!e)
        return;
    for (unsigned k = 0; e->scratch && k < e->n_threads; k++)
        free(e->scratch[k].body);
    free(e->scratch);
    free(e->tile);
    free(e);
}

static void encode_tile(void *ctx, uint32_t task, unsigned thread)
{
    struct dx_bench_encoder *e = ctx;
    struct scratch *s = &e->scratch[thread];

    if (!dx_terrain_tile(e->terrain, e->tile[task], &s->tile)) {
        s->done.n_bytes += dx_chunk_put_empty(s->body, e->encoding, s->tile.row, s->tile.col);
    } else if (e->encoding == DX_ENCODING_Q16) {
        s->done.n_bytes += dx_chunk_put_q16(s->body, &s->tile);
    } else if (e->encoding == DX_ENCODING_DELTA) {
        s->done.n_bytes += dx_chunk_put_delta(s->body, &s->tile);
    } else {
        s->done.n_bytes += dx_chunk_put_f32(s->body, &s->tile, dx_terrain_tiling(e->terrain),
                                            dx_terrain_geometry(e->terrain));
        s->done.n_triangles += dx_get_u16(s->body + DX_CHUNK_TRIANGLES_AT);
    }
}

struct dx_bench_encoded dx_bench_encode(struct dx_bench_encoder *e, const struct dx_terrain *t,
                                        enum dx_encoding encoding, bool all, struct dx_pool *pool)
{
    const uint32_t n_tiles = dx_tiling_n_tiles(dx_terrain_tiling(t));
    struct dx_bench_encoded sum = {0};
    uint32_t n_jobs = 0;

    e->terrain = t;
    e->encoding = encoding;
    for (uint32_t k = 0; k < n_tiles; k++)
        if (all || dx_marks_has(dx_terrain_changed(t), k))
            e->tile[n_jobs++] = k;
    for (unsigned k = 0; k < e->n_threads; k++)
        e->scratch[k].done = sum;
    dx_pool_run_tiles(pool, n_jobs, encode_tile, e);
    for (unsigned k = 0; k < e->n_threads; k++) {
        sum.n_bytes += e->scratch[k].done.n_bytes;
        sum.n_triangles += e->scratch[k].done.n_triangles;
    }
    return sum;
}

/* ---- memory -----------------------------------------------------------------------------------
 */

int dx_bench_memory_init(struct dx_bench_memory *m)
{
    m->from = malloc(DX_BENCH_MEMORY_LEN);
    m->to = malloc(DX_BENCH_MEMORY_LEN);
    if (!m->from || !m->to)
        return -ENOMEM;
    memset(m->from, 1, DX_BENCH_MEMORY_LEN); /* else all of it is one page of zeros */
    memset(m->to, 2, DX_BENCH_MEMORY_LEN);
    return 0;
}

void dx_bench_memory_fini(struct dx_bench_memory *m)
{
    free(m->from);
    free(m->to);
}

struct copy {
    struct dx_bench_memory *memory;
    size_t len; /* of a task */
};

static void copy_part(void *ctx, uint32_t task, unsigned thread)
{
    const struct copy *c = ctx;
    size_t at = task * c->len;

    (void)thread;
    memcpy(c->memory->to + at, c->memory->from + at, c->len);
}

void dx_bench_memory_copy(struct dx_bench_memory *m, struct dx_pool *pool)
{
    uint32_t n_tasks = 16;
    struct copy c = {m, DX_BENCH_MEMORY_LEN / n_tasks};

    dx_pool_run(pool, n_tasks, copy_part, &c);
}
