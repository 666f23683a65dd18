/*
 * From frames to the published array. Without a hold every difference is published. With one, the
 * dexels of a tile are published together as soon as one of them has moved: it costs nothing more,
 * since the tile is sent anyway, and leaves every dexel in the middle of its hold again. (Dexels
 * published one by one stay at the edges of theirs, and of a tile's thousands one always crosses.)
 */
#include "core/base/bytes.h"
#include "core/grid/terrain_priv.h"

#include <string.h>

/* Triangles that a normal of the tile counts belong to cells or struts within this distance of the
 * tile's own: struts reach two dexels out of it, and those that meet them there three more. */
#define NORMAL_REACH 5

void dx_terrain_mark_tiles(struct dx_terrain *t, const struct dx_rect *dexels)
{
    const uint32_t halo = t->gates.margin + (t->params.normals ? NORMAL_REACH : 0) + 1;

    dx_marks_set(t->marked, &t->tiling, dexels, halo, halo - 1); /* cells, and a dexel's own four */
}

/* Dexels have changed: so can the tiles around, or the smoothed ranges around. */
static void mark(struct dx_terrain *t, const struct dx_rect *dexels)
{
    if (t->smoothing)
        dx_smoothing_mark(t->smoothing, dexels);
    else
        dx_terrain_mark_tiles(t, dexels);
}

/* ---- the noise ------------------------------------------------------------------------------ */

/* The constants that follow from the noise as it is known now. */
static void set_noise(struct dx_terrain *t)
{
    dx_gates_set(&t->gates, t->geometry, &t->params);
    t->gates_set = true;
    if (t->smoothing)
        dx_smoothing_set(t->smoothing, &t->gates);
    if (t->params.sigma_given)
        dx_estimator_settle(&t->estimator, &t->gates.sigma);
}

/* From the first frame that can tell it. */
static void settle_noise(struct dx_terrain *t, const struct dx_plane *frame)
{
    t->params.sigma_given = dx_noise_estimate(t->params.sigma, frame, t->geometry);
    if (t->gates_set && !t->params.sigma_given)
        return; /* the floor still */
    set_noise(t);
    dx_marks_set_all(t->marked, &t->tiling);
}

/* ---- what differs --------------------------------------------------------------------------- */

/* Widens `moved` by those of n elements from column `col` on that differ; some do. */
static void widen(struct dx_rect *moved, const uint8_t *x, const uint8_t *y, size_t size,
                  uint32_t col, uint32_t n)
{
    uint32_t first = 0, last = n - 1;

    while (col + first < moved->col0 && memcmp(x + first * size, y + first * size, size) == 0)
        first++;
    while (col + last > moved->col1 && memcmp(x + last * size, y + last * size, size) == 0)
        last--;
    moved->col0 = col + first < moved->col0 ? col + first : moved->col0;
    moved->col1 = col + last > moved->col1 ? col + last : moved->col1;
}

/* memcmp of a tile's columns, of which most are the same: a call each takes longer. */
static inline bool differ(const uint8_t *x, const uint8_t *y, size_t n)
{
    for (; n >= 64; n -= 64, x += 64, y += 64) {
        uint64_t other = 0;

        for (size_t k = 0; k < 64; k += 8)
            other |= dx_get_u64(x + k) ^ dx_get_u64(y + k);
        if (other)
            return true;
    }
    return memcmp(x, y, n) != 0;
}

/* Copies n elements from column `col` on of a row; whether they differed. */
static inline bool replace(struct dx_rect *moved, void *to, const void *from, size_t size,
                           uint32_t col, uint32_t n)
{
    if (!differ(to, from, n * size))
        return false;
    if (col < moved->col0 || col + n - 1 > moved->col1) /* else it is as wide */
        widen(moved, to, from, size, col, n);
    memcpy(to, from, n * size);
    return true;
}

static void grow(struct dx_rect *moved, uint32_t row)
{
    moved->row0 = moved->row0 < row ? moved->row0 : row;
    moved->row1 = row;
}

static bool replace_attrs(struct dx_rect *moved, struct dx_plane *to, const struct dx_plane *from,
                          size_t at, uint32_t col, uint32_t n)
{
    const size_t bytes = to->attr_bytes;

    return bytes && replace(moved, (uint8_t *)to->attr + at * bytes,
                            (const uint8_t *)from->attr + at * bytes, bytes, col, n);
}

/* ---- what comes ----------------------------------------------------------------------------- */

/* Columns [col0, end) of a frame, which belong to columns first to last of the tiles. */
struct incoming {
    struct dx_terrain *t;
    const struct dx_plane *frame;
    uint32_t col0, end, first, last;
    const struct dx_plane *source, *attr; /* what is published, and its attributes */
    uint32_t hold;                        /* of estimates, in force: 0 until the noise is known */
    struct dx_row_hold row_hold;
};

/* What has come of a column of tiles. */
struct columns {
    uint32_t first, n;
};

static struct columns columns_of(const struct incoming *in, uint32_t tile_col)
{
    const struct dx_tiling *g = &in->t->tiling;
    uint32_t first = tile_col * DX_TILE_CELLS;
    uint32_t end = tile_col + 1 < g->cols ? first + DX_TILE_CELLS : g->width;

    first = first > in->col0 ? first : in->col0;
    end = end < in->end ? end : in->end;
    return (struct columns){first, end - first};
}

static void begin_moved(struct dx_terrain *t, uint32_t tile)
{
    t->moved[tile] = (struct dx_rect){.row0 = UINT32_MAX, .col0 = UINT32_MAX};
}

/* ---- frames as they are --------------------------------------------------------------------- */

static void publish_segment(const struct incoming *in, struct columns c, uint32_t row,
                            struct dx_rect *moved)
{
    const struct dx_plane *from = in->source;
    struct dx_plane *to = in->t->sampled;
    const size_t rb = to->range_bytes, at = (size_t)row * to->width + c.first;
    bool differs = replace(moved, (uint8_t *)to->range + at * rb,
                           (const uint8_t *)from->range + at * rb, rb, c.first, c.n);

    differs |= replace_attrs(moved, to, in->attr, at, c.first, c.n);
    if (to->xyz)
        differs |=
            replace(moved, to->xyz + 3 * at, from->xyz + 3 * at, 3 * sizeof(float), c.first, c.n);
    if (differs)
        grow(moved, row);
}

static bool is_same(const struct dx_plane *x, const struct dx_plane *y, size_t at, size_t n)
{
    const size_t rb = y->range_bytes, ab = x->attr_bytes, pb = 3 * sizeof(float);

    return memcmp((uint8_t *)x->range + at * rb, (uint8_t *)y->range + at * rb, n * rb) == 0 &&
           (!ab ||
            memcmp((uint8_t *)x->attr + at * ab, (uint8_t *)y->attr + at * ab, n * ab) == 0) &&
           (!x->xyz || memcmp(x->xyz + 3 * at, y->xyz + 3 * at, n * pb) == 0);
}

/* A row of tiles, by rows of dexels as they lie in memory: most are the same where little moves.
 * Each tile has a rectangle of its own, no wider than what has changed in it, so that neighbours
 * are computed anew only where the change comes near them. */
static void publish_frame(void *ctx, uint32_t band, unsigned thread)
{
    const struct incoming *in = ctx;
    struct dx_terrain *t = in->t;
    const uint32_t tile0 = band * t->tiling.cols;
    const struct dx_rect rows = dx_marks_part(&t->tiling, tile0);

    (void)thread;
    for (uint32_t k = in->first; k <= in->last; k++)
        begin_moved(t, tile0 + k);
    for (uint32_t row = rows.row0; row <= rows.row1; row++) {
        const size_t at = (size_t)row * t->tiling.width + in->col0;

        if (is_same(t->sampled, in->frame, at, in->end - in->col0))
            continue;
        for (uint32_t k = in->first; k <= in->last; k++)
            publish_segment(in, columns_of(in, k), row, &t->moved[tile0 + k]);
    }
}

/* ---- estimates ------------------------------------------------------------------------------ */

static uint64_t hold_at(const struct dx_terrain *t, uint32_t hold, uint32_t range)
{
    return (uint64_t)hold * dx_sigma_at(&t->gates.sigma, range) >> 8;
}

/* Whether a dexel has moved too far from what is published. One that rounds to the same range has
 * not: publishing it would change nothing. */
static bool has_moved(const struct incoming *in, const struct dx_estimates *e, uint32_t k,
                      uint32_t published)
{
    const uint64_t estimate = dx_estimate_at(e, k);
    const uint64_t at = (uint64_t)published << DX_ESTIMATE_FRACTION;
    const uint64_t distance = estimate > at ? estimate - at : at - estimate;

    if ((estimate != 0) != (published != 0))
        return true;
    return e->range[k] != published && distance > hold_at(in->t, in->hold, published);
}

/* DX_ROWS_CELLS of a row's columns at the most, from the k-th estimate on. */
static bool some_have_moved(const struct incoming *in, const struct dx_estimates *e, size_t at,
                            uint32_t k, uint32_t n)
{
    const struct dx_terrain *t = in->t;
    uint32_t published[DX_ROWS_CELLS];
    uint64_t may;

    dx_plane_get_ranges(t->sampled, at, n, published, DX_ROWS_CELLS);
    may = t->gates.rows->filters.may_have_moved(e->fine + k, published, &in->row_hold);
    for (may &= (uint64_t)dx_bits_below(n); may; may &= may - 1) {
        const uint32_t j = (uint32_t)__builtin_ctzll(may);

        if (has_moved(in, e, k + j, published[j]))
            return true;
    }
    return false;
}

/* A hold is over ranges; an attribute alone (the intensity's noise) does not end it. */
static bool row_has_moved(const struct incoming *in, const struct dx_estimates *e, size_t at,
                          uint32_t n)
{
    const struct dx_plane *to = in->t->sampled;
    const size_t bytes = to->attr_bytes;

    for (uint32_t k = 0; k < n; k += DX_ROWS_CELLS)
        if (some_have_moved(in, e, at + k, k, n - k < DX_ROWS_CELLS ? n - k : DX_ROWS_CELLS))
            return true;
    return bytes && in->hold == 0 &&
           differ((const uint8_t *)in->attr->attr + at * bytes,
                  (const uint8_t *)to->attr + at * bytes, n * bytes);
}

/* Takes what has come of a row; which tiles are due. */
static void take_row(const struct incoming *in, uint32_t tile0, uint32_t row)
{
    struct dx_terrain *t = in->t;
    struct dx_estimates e;

    for (uint32_t k = in->first; k <= in->last; k++) {
        const struct columns c = columns_of(in, k);
        const size_t at = (size_t)row * t->tiling.width + c.first;

        dx_estimator_take(&t->estimator, in->frame, row, c.first, c.n, &e);
        dx_plane_put_ranges(&t->estimated, at, c.n, e.range);
        if (!t->due[tile0 + k])
            t->due[tile0 + k] = row_has_moved(in, &e, at, c.n);
    }
}

/* A row of tiles, by rows of dexels as they lie in memory, and then the tiles that are due. */
static void publish_estimates(void *ctx, uint32_t band, unsigned thread)
{
    const struct incoming *in = ctx;
    struct dx_terrain *t = in->t;
    const uint32_t tile0 = band * t->tiling.cols, keyframe = t->params.ingest.keyframe;
    const struct dx_rect rows = dx_marks_part(&t->tiling, tile0);

    (void)thread;
    for (uint32_t k = in->first; k <= in->last; k++) {
        begin_moved(t, tile0 + k);
        t->due[tile0 + k] =
            keyframe && t->estimator.n_taken[columns_of(in, k).first] % keyframe == 0;
    }
    for (uint32_t row = rows.row0; row <= rows.row1; row++)
        take_row(in, tile0, row);
    for (uint32_t row = rows.row0; row <= rows.row1; row++)
        for (uint32_t k = in->first; k <= in->last; k++)
            if (t->due[tile0 + k])
                publish_segment(in, columns_of(in, k), row, &t->moved[tile0 + k]);
}

/* Estimates are published, and held. */
static void set_estimates(struct incoming *in)
{
    const struct dx_terrain *t = in->t;
    uint64_t surely;

    in->source = &t->estimated;
    if (t->params.ingest.filter)
        in->attr = &t->estimator.newest;
    in->hold = t->params.sigma_given ? t->hold : 0;
    surely = hold_at(t, in->hold, 0);
    in->row_hold =
        (struct dx_row_hold){.sigma = t->gates.row_sigma,
                             .surely_held = surely < UINT32_MAX ? (uint32_t)surely : UINT32_MAX,
                             .sigmas = in->hold / 256.0};
}

/* ---- both ----------------------------------------------------------------------------------- */

static uint32_t column_of(const struct dx_tiling *g, uint32_t col)
{
    const uint32_t tile = col / DX_TILE_CELLS;

    return tile < g->cols ? tile : g->cols - 1; /* the last one has the rest */
}

static void mark_moved(const struct incoming *in)
{
    struct dx_terrain *t = in->t;

    for (uint32_t row = 0; row < t->tiling.rows; row++)
        for (uint32_t k = in->first; k <= in->last; k++) {
            const struct dx_rect *moved = &t->moved[row * t->tiling.cols + k];

            if (moved->row0 != UINT32_MAX)
                mark(t, moved);
        }
}

void dx_terrain_publish(struct dx_terrain *t, const struct dx_plane *frame, uint32_t col0,
                        uint32_t n_cols, struct dx_pool *pool)
{
    struct incoming in = {.t = t,
                          .frame = frame,
                          .col0 = col0,
                          .end = col0 + n_cols,
                          .first = column_of(&t->tiling, col0),
                          .last = column_of(&t->tiling, col0 + n_cols - 1),
                          .source = frame,
                          .attr = frame};

    if (!t->params.sigma_given && (n_cols == frame->width || !t->gates_set))
        settle_noise(t, frame);
    if (!t->gates_set)
        set_noise(t);
    if (t->params.ingest.filter == DX_FILTER_OFF && t->hold == 0) {
        dx_pool_run_tiles(pool, t->tiling.rows, publish_frame, &in);
    } else {
        set_estimates(&in);
        dx_estimator_begin(&t->estimator, frame, col0, n_cols);
        dx_pool_run(dx_pool_for_tiles(pool, t->tiling.rows * (in.last - in.first + 1)),
                    t->tiling.rows, publish_estimates, &in);
    }
    mark_moved(&in);
}

void dx_terrain_forget(struct dx_terrain *t)
{
    dx_estimator_forget(&t->estimator);
}
