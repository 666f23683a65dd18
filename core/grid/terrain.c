/*
 * The published array and its mesh, tile by tile: what changed is marked when it is published
 * (publish.c), marked tiles are computed anew at the commit, and a tile has changed when its
 * content hash has.
 */
#include "core/grid/terrain.h"

#include "core/grid/faces.h"
#include "core/grid/terrain_priv.h"
#include "core/grid/tile_hash.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

void dx_terrain_params_default(struct dx_terrain_params *p)
{
    *p = (struct dx_terrain_params){.tilt_deg = 78.69,
                                    .noise_k = 4,
                                    .diag = DX_DIAG_BEND,
                                    .rescue = true,
                                    .mixed = DX_MIXED_AXIS,
                                    .bridge = 1};
    p->ingest = (struct dx_ingest_params){.n_max = 16, .n_gap = 2, .hold = -1};
}

static const char *check_ingest(const struct dx_ingest_params *p)
{
    if (p->filter == DX_FILTER_MEAN && (p->n_max < 1 || p->n_max > 255))
        return "a mean must be of 1 to 255 frames";
    if (p->filter == DX_FILTER_MEAN && p->n_gap > 254)
        return "gap must be at most 254 frames";
    if (!(p->hold <= 100)) /* what is below 0 stands for the default */
        return "hold must be from 0 to 100 sigmas";
    return NULL;
}

const char *dx_terrain_params_check(const struct dx_terrain_params *p)
{
    for (int k = 0; k < 3; k++)
        if (!(p->sigma[k] >= 0 && p->sigma[k] <= 1000))
            return "sigma must be three numbers from 0 to 1000";
    if (!(p->tilt_deg >= 0 && p->tilt_deg <= 89))
        return "tilt must be from 0 to 89 degrees";
    if (!(p->noise_k >= 0 && p->noise_k <= 100))
        return "noise gate must be from 0 to 100 sigmas";
    if (!(p->cap_m >= 0 && p->cap_m <= 1e6))
        return "cap must be from 0 to 1000000 metres";
    if (p->paper && p->cap_m == 0)
        return "the paper's mode needs a cap: the radius of its sphere of influence";
    if (p->diag != DX_DIAG_FIXED && p->diag != DX_DIAG_SHORT && p->diag != DX_DIAG_BEND)
        return "diag must be fixed, short or bend";
    if (p->mixed != DX_MIXED_OFF && p->mixed != DX_MIXED_AXIS && p->mixed != DX_MIXED_STRICT)
        return "mixed must be off, axis or strict";
    if (p->bridge > 2)
        return "bridge must be 0, 1 or 2";
    if (!dx_rows_get(p->simd))
        return "this processor has no such instructions";
    return check_ingest(&p->ingest);
}

/* The hold in 1/256 sigma. */
static uint32_t hold_of(const struct dx_ingest_params *p)
{
    double hold = p->hold >= 0 ? p->hold : p->filter ? DX_HOLD_SIGMAS : 0;

    return (uint32_t)rint(256 * hold);
}

const char *dx_terrain_params_check_exact(const struct dx_terrain_params *p)
{
    if (p->ingest.filter != DX_FILTER_OFF)
        return "exact points need filter off: an estimate is no sample";
    if (hold_of(&p->ingest) != 0)
        return "exact points need hold 0: every difference is published";
    if (p->smooth)
        return "exact points need smooth off: a smoothed range is no sample";
    return NULL;
}

/* What samples are published through. */
static int init_stages(struct dx_terrain *t)
{
    int r = dx_estimator_init(&t->estimator, &t->params.ingest, &t->published,
                              dx_rows_get(t->params.simd));

    if (r == 0 && (t->params.ingest.filter || t->hold))
        r = dx_plane_init(&t->estimated, t->geometry->height, t->geometry->width,
                          t->geometry->range_bytes, 0);
    if (r == 0)
        r = dx_gates_init(&t->gates, t->geometry);
    if (r == 0 && t->params.smooth)
        r = dx_smoothing_new(&t->smoothing, t->geometry, &t->tiling, &t->published,
                             dx_estimator_noise(&t->params.ingest), t->gates.per_dexel);
    t->sampled = t->smoothing ? &t->smoothing->sampled : &t->published;
    return r;
}

int dx_terrain_new(struct dx_terrain **out, struct dx_geometry *g,
                   const struct dx_terrain_params *params, uint8_t attr_bytes)
{
    struct dx_terrain *t;
    size_t n_tiles;
    int r;

    if (dx_terrain_params_check(params) || g->height < 2 || g->width < 2 ||
        (g->exact && dx_terrain_params_check_exact(params)))
        return -EINVAL;
    t = calloc(1, sizeof(*t));
    if (!t)
        return -ENOMEM;
    t->geometry = dx_geometry_ref(g);
    t->params = *params;
    dx_tiling_init(&t->tiling, g->height, g->width, g->wrap);
    n_tiles = dx_tiling_n_tiles(&t->tiling);
    t->n_scratch = DX_POOL_MAX_THREADS;
    t->code = calloc(n_tiles, DX_TILE_CELLS * DX_TILE_CELLS);
    t->strut = calloc(n_tiles, DX_BLOCK_DEXELS);
    t->has_struts = calloc(n_tiles, sizeof(*t->has_struts));
    t->hash = calloc(n_tiles, sizeof(*t->hash));
    t->marked = calloc(dx_marks_n_words(&t->tiling), sizeof(*t->marked));
    t->changed = calloc(dx_marks_n_words(&t->tiling), sizeof(*t->changed));
    t->task = calloc(n_tiles, sizeof(*t->task));
    t->scratch = calloc(t->n_scratch, sizeof(*t->scratch)); /* touched by the threads there are */
    t->hold = hold_of(&params->ingest);
    t->moved = calloc(n_tiles, sizeof(*t->moved));
    t->due = calloc(n_tiles, sizeof(*t->due));
    r = dx_plane_init_for(&t->published, g, attr_bytes);
    if (r == 0)
        r = init_stages(t);
    if (r == 0 && (!t->code || !t->strut || !t->has_struts || !t->hash || !t->marked ||
                   !t->changed || !t->task || !t->scratch || !t->moved || !t->due))
        r = -ENOMEM;
    if (r < 0) {
        dx_terrain_free(t);
        return r;
    }
    if (params->caps && g->model == DX_MODEL_SPINNING && g->wrap)
        t->fans = (dx_faces_fan(g, 0, true) ? DX_CAP_FIRST : 0) |
                  (dx_faces_fan(g, g->height - 1, false) ? DX_CAP_LAST : 0);
    *out = t;
    return 0;
}

void dx_terrain_free(struct dx_terrain *t)
{
    if (!t)
        return;
    dx_plane_fini(&t->published);
    dx_smoothing_free(t->smoothing);
    dx_estimator_fini(&t->estimator);
    free(t->due);
    free(t->moved);
    dx_plane_fini(&t->estimated);
    free(t->scratch);
    free(t->task);
    free(t->changed);
    free(t->marked);
    free(t->hash);
    free(t->has_struts);
    free(t->strut);
    free(t->code);
    dx_gates_fini(&t->gates);
    dx_geometry_unref(t->geometry);
    free(t);
}

const struct dx_tiling *dx_terrain_tiling(const struct dx_terrain *t)
{
    return &t->tiling;
}

const struct dx_geometry *dx_terrain_geometry(const struct dx_terrain *t)
{
    return t->geometry;
}

const struct dx_plane *dx_terrain_published(const struct dx_terrain *t)
{
    return &t->published;
}

const struct dx_terrain_params *dx_terrain_params(const struct dx_terrain *t)
{
    return &t->params;
}

const uint64_t *dx_terrain_changed(const struct dx_terrain *t)
{
    return t->changed;
}

/* ---- committing ----------------------------------------------------------------------------- */

static void note_hash(struct dx_terrain *t, uint32_t task, uint64_t hash)
{
    const uint32_t number = t->task[task];

    t->task[task] = hash != t->hash[number] ? number : UINT32_MAX;
    t->hash[number] = hash;
}

/* Whether tiles say more than codes and ranges: what the rules do not look at. */
static bool says_more(const struct dx_terrain *t)
{
    return t->published.attr_bytes || t->published.xyz || t->params.normals;
}

/* The outcome of a marked tile, and whether it has changed. Tasks write disjoint words: one hash a
 * tile; the changed bits are set by the caller. */
static void decide_tile(void *ctx, uint32_t task, unsigned thread)
{
    struct dx_terrain *t = ctx;
    const uint32_t number = t->task[task];
    struct dx_rules_scratch *s = &t->scratch[thread].rules;
    const struct dx_outcome out = {.row = number / t->tiling.cols,
                                   .col = number % t->tiling.cols,
                                   .code = t->code + (size_t)number * DX_TILE_CELLS * DX_TILE_CELLS,
                                   .strut = t->strut + (size_t)number * DX_BLOCK_DEXELS,
                                   .has_struts = t->has_struts + number};

    dx_rules_apply(&out, s, &t->published, &t->tiling, t->geometry, &t->gates);
    if (!says_more(t))
        note_hash(t, task, dx_tile_hash_outcome(&out, s, t->gates.rows));
}

/* The same of a tile that says more; after all outcomes, since normals look at neighbours. */
static void compare_tile(void *ctx, uint32_t task, unsigned thread)
{
    struct dx_terrain *t = ctx;
    struct dx_tile *tile = &t->scratch[thread].tile;

    note_hash(t, task, dx_terrain_tile(t, t->task[task], tile) ? dx_tile_hash(tile) : 0);
}

/* From the samples to the published array. */
static void smooth(struct dx_terrain *t, struct dx_pool *pool)
{
    const uint32_t n = dx_smoothing_run(t->smoothing, &t->published, pool);

    for (uint32_t k = 0; k < n; k++)
        if (t->smoothing->changed[k].row0 <= t->smoothing->changed[k].row1)
            dx_terrain_mark_tiles(t, &t->smoothing->changed[k]);
}

uint32_t dx_terrain_commit(struct dx_terrain *t, struct dx_pool *pool)
{
    uint32_t n_tiles = dx_tiling_n_tiles(&t->tiling), n = 0, n_changed = 0;

    if (t->smoothing && t->gates_set)
        smooth(t, pool);
    memset(t->changed, 0, dx_marks_n_words(&t->tiling) * sizeof(*t->changed));
    for (uint32_t k = 0; t->gates_set && k < n_tiles; k++)
        if (dx_marks_has(t->marked, k))
            t->task[n++] = k;
    memset(t->marked, 0, dx_marks_n_words(&t->tiling) * sizeof(*t->marked));
    dx_pool_run_tiles(pool, n, decide_tile, t);
    if (says_more(t))
        dx_pool_run_tiles(pool, n, compare_tile, t);
    for (uint32_t k = 0; k < n; k++)
        if (t->task[k] != UINT32_MAX) {
            t->changed[t->task[k] / 64] |= 1ull << (t->task[k] % 64);
            n_changed++;
        }
    return n_changed;
}

/* ---- caps ----------------------------------------------------------------------------------- */

/* Whether all cells of a row of the grid have one of the outcomes in `codes`. */
static bool row_has(const struct dx_terrain *t, uint32_t row, uint32_t codes)
{
    const uint32_t tile_row = row / DX_TILE_CELLS, i = row % DX_TILE_CELLS;

    for (uint32_t j = 0; j < t->tiling.cell_cols; j++) {
        size_t number = (size_t)tile_row * t->tiling.cols + j / DX_TILE_CELLS;
        size_t cell = i * DX_TILE_CELLS + j % DX_TILE_CELLS;

        if (!(1u << t->code[number * DX_TILE_CELLS * DX_TILE_CELLS + cell] & codes))
            return false;
    }
    return true;
}

uint32_t dx_terrain_caps(const struct dx_terrain *t)
{
    const uint32_t both = 1u << DX_CELL_ABC_ACD | 1u << DX_CELL_ABD_BCD;
    const uint32_t top = both | 1u << DX_CELL_ABC | 1u << DX_CELL_ABD; /* a triangle on side a-b */
    const uint32_t bottom = both | 1u << DX_CELL_ACD | 1u << DX_CELL_BCD;
    uint32_t caps = 0;

    if (t->fans & DX_CAP_FIRST && row_has(t, 0, top))
        caps |= DX_CAP_FIRST;
    if (t->fans & DX_CAP_LAST && row_has(t, t->tiling.cell_rows - 1, bottom))
        caps |= DX_CAP_LAST;
    return caps;
}
