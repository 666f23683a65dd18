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

/* ---- frames as they are --------------------------------------------------------------------- */

/* Widens `moved` by those of columns [col, end) that differ, of `size` bytes each; some do. */
static void widen(struct dx_rect *moved, const uint8_t *x, const uint8_t *y, size_t size,
                  uint32_t col, uint32_t end)
{
    uint32_t last = end - 1;

    while (col < moved->col0 && memcmp(x + col * size, y + col * size, size) == 0)
        col++;
    while (last > moved->col1 && memcmp(x + last * size, y + last * size, size) == 0)
        last--;
    moved->col0 = col < moved->col0 ? col : moved->col0;
    moved->col1 = last > moved->col1 ? last : moved->col1;
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

/* Copies such columns; whether they differed. */
static inline bool replace(struct dx_rect *moved, uint8_t *to, const uint8_t *from, size_t size,
                           uint32_t col, uint32_t end)
{
    const size_t at = col * size, n = (end - col) * size;

    if (!differ(to + at, from + at, n))
        return false;
    if (col < moved->col0 || end - 1 > moved->col1) /* else it is as wide */
        widen(moved, to, from, size, col, end);
    memcpy(to + at, from + at, n);
    return true;
}

/* Columns [col, end) of a row; whether any of them differed. */
static bool publish_segment(const struct dx_terrain *t, const struct dx_plane *frame, uint32_t row,
                            uint32_t col, uint32_t end, struct dx_rect *moved)
{
    const size_t rb = frame->range_bytes, ab = t->sampled->attr_bytes, pb = 3 * sizeof(float);
    const size_t at = (size_t)row * frame->width;
    bool differs = replace(moved, (uint8_t *)t->sampled->range + at * rb,
                           (const uint8_t *)frame->range + at * rb, rb, col, end);

    if (ab)
        differs |= replace(moved, (uint8_t *)t->sampled->attr + at * ab,
                           (const uint8_t *)frame->attr + at * ab, ab, col, end);
    if (t->sampled->xyz)
        differs |= replace(moved, (uint8_t *)(t->sampled->xyz + 3 * at),
                           (const uint8_t *)(frame->xyz + 3 * at), pb, col, end);
    return differs;
}

static bool is_same(const struct dx_terrain *t, const struct dx_plane *frame, size_t at, size_t n)
{
    size_t rb = frame->range_bytes, ab = t->sampled->attr_bytes;

    return memcmp((const uint8_t *)t->sampled->range + at * rb,
                  (const uint8_t *)frame->range + at * rb, n * rb) == 0 &&
           (!ab || memcmp((const uint8_t *)t->sampled->attr + at * ab,
                          (const uint8_t *)frame->attr + at * ab, n * ab) == 0) &&
           (!t->sampled->xyz || memcmp(t->sampled->xyz + 3 * at, frame->xyz + 3 * at,
                                       3 * n * sizeof(*frame->xyz)) == 0);
}

/* Row `row` by tiles, whose rectangles of what has changed grow by it: no wider than that, so that
 * a tile's neighbours are computed anew only where the change comes near them. */
static void publish_tiles(struct dx_terrain *t, const struct dx_plane *frame, uint32_t row,
                          uint32_t col0, uint32_t n_cols)
{
    for (uint32_t j = col0, end; j < col0 + n_cols; j = end) {
        struct dx_rect *moved = &t->moved[j / DX_TILE_CELLS];

        end = (j / DX_TILE_CELLS + 1) * DX_TILE_CELLS;
        end = end < col0 + n_cols ? end : col0 + n_cols;
        if (publish_segment(t, frame, row, j, end, moved)) {
            moved->row0 = moved->row0 < row ? moved->row0 : row;
            moved->row1 = row;
        }
    }
}

/* By rows, as they lie in memory; most are the same where little moves. Tiles are marked once for
 * their rows. */
static void publish_frame(struct dx_terrain *t, const struct dx_plane *frame, uint32_t col0,
                          uint32_t n_cols)
{
    const uint32_t first = col0 / DX_TILE_CELLS;
    const uint32_t beyond = (col0 + n_cols + DX_TILE_CELLS - 1) / DX_TILE_CELLS;

    for (uint32_t row = 0; row < frame->height;) {
        const uint32_t end = (row / DX_TILE_CELLS + 1) * DX_TILE_CELLS;

        for (uint32_t k = first; k < beyond; k++)
            t->moved[k] = (struct dx_rect){.row0 = UINT32_MAX, .col0 = UINT32_MAX};
        for (; row < frame->height && row < end; row++)
            if (!is_same(t, frame, (size_t)row * frame->width + col0, n_cols))
                publish_tiles(t, frame, row, col0, n_cols);
        for (uint32_t k = first; k < beyond; k++)
            if (t->moved[k].row0 != UINT32_MAX)
                mark(t, &t->moved[k]);
    }
}

/* ---- estimates, part by part ---------------------------------------------------------------- */

/* The dexels of one tile that are at hand. */
struct part {
    uint32_t row0, n_rows, col0, n_cols;
    const struct dx_plane *attr; /* where their attributes are */
    uint32_t hold;               /* in force: 0 until the noise is known */
    uint64_t surely_held;        /* 1/256 unit: within the hold at every range */
};

static uint32_t rounded(uint64_t estimate)
{
    return (uint32_t)((estimate + (1u << (DX_ESTIMATE_FRACTION - 1))) >> DX_ESTIMATE_FRACTION);
}

static uint64_t hold_at(const struct dx_terrain *t, uint32_t hold, uint32_t range)
{
    return (uint64_t)hold * dx_sigma_at(&t->gates.sigma, range) >> 8;
}

/* Whether a dexel has moved too far from what is published. One that rounds to the same range has
 * not: publishing it would change nothing. */
static bool has_moved(const struct dx_terrain *t, const struct part *p, uint64_t estimate,
                      uint32_t published)
{
    uint64_t at = (uint64_t)published << DX_ESTIMATE_FRACTION;
    uint64_t distance = estimate > at ? estimate - at : at - estimate;

    if ((estimate != 0) != (published != 0))
        return true;
    if (distance <= p->surely_held)
        return false;
    return rounded(estimate) != published && distance > hold_at(t, p->hold, published);
}

/* A hold is over ranges; an attribute alone (the intensity's noise) does not end it. */
static bool row_has_moved(const struct dx_terrain *t, const struct part *p, uint32_t row,
                          const uint64_t *estimate)
{
    size_t at = (size_t)row * t->sampled->width + p->col0;

    for (uint32_t k = 0; k < p->n_cols; k++)
        if (has_moved(t, p, estimate[k], dx_plane_range(t->sampled, at + k)) ||
            (p->hold == 0 && dx_plane_attr(p->attr, at + k) != dx_plane_attr(t->sampled, at + k)))
            return true;
    return false;
}

static void publish_row(struct dx_terrain *t, const struct part *p, uint32_t row,
                        const uint64_t *estimate)
{
    uint32_t first = UINT32_MAX, last = 0;

    for (uint32_t k = 0; k < p->n_cols; k++) {
        size_t at = (size_t)row * t->sampled->width + p->col0 + k;
        uint32_t range = rounded(estimate[k]), attr = dx_plane_attr(p->attr, at);

        if (dx_plane_range(t->sampled, at) == range && dx_plane_attr(t->sampled, at) == attr)
            continue;
        dx_plane_set_range(t->sampled, at, range);
        dx_plane_set_attr(t->sampled, at, attr);
        first = first < k ? first : k;
        last = k;
    }
    if (first != UINT32_MAX)
        mark(t, &(struct dx_rect){row, row, p->col0 + first, p->col0 + last});
}

static void publish_part(struct dx_terrain *t, const struct dx_plane *frame, const struct part *p)
{
    uint32_t keyframe = t->params.ingest.keyframe;
    bool due = keyframe && t->estimator.n_taken[p->col0] % keyframe == 0;

    for (uint32_t i = 0; i < p->n_rows; i++) {
        uint64_t *estimate = t->estimate + (size_t)i * DX_PART_SIDE;

        dx_estimator_take(&t->estimator, frame, p->row0 + i, p->col0, p->n_cols, estimate);
        due = due || row_has_moved(t, p, p->row0 + i, estimate);
    }
    for (uint32_t i = 0; due && i < p->n_rows; i++)
        publish_row(t, p, p->row0 + i, t->estimate + (size_t)i * DX_PART_SIDE);
}

static void publish_estimates(struct dx_terrain *t, const struct dx_plane *frame, uint32_t col0,
                              uint32_t n_cols)
{
    struct part p = {.attr = t->params.ingest.filter ? &t->estimator.newest : frame,
                     .hold = t->params.sigma_given ? t->hold : 0};

    p.surely_held = hold_at(t, p.hold, 0);
    dx_estimator_begin(&t->estimator, frame, col0, n_cols);
    for (uint32_t n = 0; n < dx_tiling_n_tiles(&t->tiling); n++) {
        struct dx_rect r = dx_marks_part(&t->tiling, n);

        p.row0 = r.row0;
        p.n_rows = r.row1 - r.row0 + 1;
        p.col0 = r.col0 > col0 ? r.col0 : col0;
        r.col1 = r.col1 < col0 + n_cols ? r.col1 : col0 + n_cols - 1;
        p.n_cols = r.col1 - p.col0 + 1;
        if (p.col0 <= r.col1)
            publish_part(t, frame, &p);
    }
}

void dx_terrain_publish(struct dx_terrain *t, const struct dx_plane *frame, uint32_t col0,
                        uint32_t n_cols)
{
    if (!t->params.sigma_given && (n_cols == frame->width || !t->gates_set))
        settle_noise(t, frame);
    if (!t->gates_set)
        set_noise(t);
    if (t->params.ingest.filter == DX_FILTER_OFF && t->hold == 0)
        publish_frame(t, frame, col0, n_cols);
    else
        publish_estimates(t, frame, col0, n_cols);
}

void dx_terrain_forget(struct dx_terrain *t)
{
    dx_estimator_forget(&t->estimator);
}
