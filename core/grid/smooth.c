/* A part's neighbourhood, what is joined in it, and the smoothed ranges back into the array. */
#include "core/grid/smooth.h"

#include "core/grid/edges.h"
#include "core/grid/lines.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define REACH        2 /* the pairs' */
#define RESCUE_REACH 2 /* what a rescued edge looks at beyond its ends */

/* A pair: the neighbours di rows and dj columns before and after, and what its word counts beside
 * that of the dexel's own sample. */
struct pair {
    int di, dj;
    float weight;
};

/* 2 exp(-d^2 / (2 * 1.2^2)) for a pair of distance d; the corners of 5 x 5 would count 0.12. */
static const struct pair pairs[DX_SMOOTH_PAIRS] = {
    {0, 1, 1.413f}, {1, 0, 1.413f}, {1, 1, 0.999f},  {1, -1, 0.999f}, {0, 2, 0.499f},
    {2, 0, 0.499f}, {1, 2, 0.352f}, {1, -2, 0.352f}, {2, 1, 0.352f},  {2, -1, 0.352f},
};

/* Of one row: which dexels are joined to the one `REACH` and fewer rows below or above (columns to
 * the right or left) of them, all edges between them included. By offset + REACH. */
typedef dx_bits paths[2 * REACH + 1];

struct dx_smooth_scratch {
    struct dx_area area;
    float inverse[DX_AREA][DX_AREA_STRIDE];
    float direction[3][DX_AREA][DX_AREA_STRIDE]; /* uneven grids only */
    paths down, along;
    struct dx_smooth_row row;
};

/* ---- making it ------------------------------------------------------------------------------ */

/* The weights of an even grid's rows, at the first column that the pair fits in. */
static void fill_lines(struct dx_smooth_line *line, const struct dx_geometry *g)
{
    for (uint32_t i = 0; i < g->height; i++)
        for (unsigned k = 0; k < DX_SMOOTH_PAIRS; k++, line++) {
            const struct pair *p = &pairs[k];
            const uint32_t j = (uint32_t)abs(p->dj);
            struct dx_line w = {0, 0};

            if (2 * j < g->width)
                w = dx_lines_at(g, i, j, p->di, p->dj);
            line->minus = (float)w.minus * 0x1p-24f;
            line->plus = (float)w.plus * 0x1p-24f;
        }
}

int dx_smooth_init(struct dx_smooth *s, const struct dx_geometry *g, double noise, bool uneven)
{
    *s = (struct dx_smooth){.noise = noise, .reach = REACH};
    s->scratch = calloc(DX_POOL_MAX_THREADS, sizeof(*s->scratch));
    if (!uneven)
        s->line = calloc((size_t)g->height * DX_SMOOTH_PAIRS, sizeof(*s->line));
    if (!s->scratch || (!uneven && !s->line)) {
        dx_smooth_fini(s);
        return -ENOMEM;
    }
    if (!uneven)
        fill_lines(s->line, g);
    return 0;
}

void dx_smooth_fini(struct dx_smooth *s)
{
    free(s->scratch);
    free(s->line);
    *s = (struct dx_smooth){0};
}

/* The noise model in 32-bit factors, where they fit. */
static void set_row_noise(struct dx_smooth *s)
{
    const struct dx_sigma *sigma = &s->gates.sigma;

    s->narrow = !s->gates.wide && sigma->a1 <= UINT32_MAX && sigma->a2 <= UINT32_MAX;
    s->row_noise = (struct dx_smooth_noise){.a0 = sigma->a0,
                                            .a1 = (uint32_t)sigma->a1,
                                            .a2 = (uint32_t)sigma->a2,
                                            .full = sigma->full,
                                            .max = DX_SIGMA_MAX};
}

void dx_smooth_set(struct dx_smooth *s, const struct dx_gates *gates)
{
    s->reach = REACH + (gates->rescue ? RESCUE_REACH : 0);
    s->gates = *gates;
    s->gates.margin = s->reach;
    s->gates.diag = DX_DIAG_FIXED; /* nothing that only diagonals need */
    set_row_noise(s);
}

/* ---- a part's neighbourhood ----------------------------------------------------------------- */

static void invert(const struct dx_smooth *s, struct dx_smooth_scratch *x)
{
    for (uint32_t p = x->area.first; p < x->area.end; p++)
        s->gates.rows->smoother.invert(x->inverse[p], x->area.range[p], DX_AREA_STRIDE);
}

static void gather_directions(struct dx_smooth_scratch *x, const struct dx_geometry *g)
{
    for (uint32_t p = x->area.first; p < x->area.end; p++)
        for (uint32_t q = 0; q < DX_AREA; q++) {
            double d[3];

            if (!x->area.range[p][q])
                continue; /* what is there is finite */
            dx_lines_direction(g, dx_area_row(&x->area, p), dx_area_col(&x->area, q, g->width), d);
            for (int k = 0; k < 3; k++)
                x->direction[k][p][q] = (float)d[k];
        }
}

/* ---- what is joined ------------------------------------------------------------------------- */

/* The paths from row p's dexels along their row and their columns. The first and last two columns
 * of the area have none: no part reaches them. */
static void find_paths(struct dx_smooth_scratch *x, uint32_t p)
{
    const dx_bits h = dx_words_at(&x->area.joined[DX_EDGE_H], p);
    const struct dx_row_words *v = &x->area.joined[DX_EDGE_V];

    x->along[REACH + 1] = h;
    x->along[REACH + 2] = h & h >> 1;
    x->along[REACH - 1] = h << 1;
    x->along[REACH - 2] = (h & h >> 1) << 2;
    x->down[REACH + 1] = dx_words_at(v, p);
    x->down[REACH + 2] = dx_words_at(v, p) & dx_words_at(v, p + 1);
    x->down[REACH - 1] = dx_words_at(v, p - 1);
    x->down[REACH - 2] = dx_words_at(v, p - 1) & dx_words_at(v, p - 2);
}

static dx_bits shifted(dx_bits row, int columns)
{
    return columns < 0 ? row << -columns : row >> columns;
}

/* The part's dexels that are joined to both ends of a pair by four paths: to each end first along
 * the row, and then the rest of it along the column. */
static dx_bits joined_by(const struct dx_smooth_scratch *x, const struct pair *pair)
{
    const dx_bits along = x->along[REACH + pair->dj] & x->along[REACH - pair->dj];
    const dx_bits after = shifted(x->down[REACH + pair->di], pair->dj);
    const dx_bits before = shifted(x->down[REACH - pair->di], -pair->dj);

    return (along & after & before) >> DX_MARGIN;
}

/* ---- a row ---------------------------------------------------------------------------------- */

static struct dx_smooth_ends ends_of(float (*array)[DX_AREA_STRIDE], uint32_t p,
                                     const struct pair *pair)
{
    return (struct dx_smooth_ends){array[(int)p - pair->di] + DX_MARGIN - pair->dj,
                                   array[p] + DX_MARGIN,
                                   array[(int)p + pair->di] + DX_MARGIN + pair->dj};
}

static void directions_of(struct dx_smooth_ends d[3], struct dx_smooth_scratch *x, uint32_t p,
                          const struct pair *pair)
{
    for (int k = 0; k < 3; k++)
        d[k] = ends_of(x->direction[k], p, pair);
}

static void find_slope(const struct dx_smooth *s, struct dx_smooth_scratch *x, uint32_t p)
{
    struct dx_smooth_cross cross = {
        .joined_before = {x->along[REACH - 1] >> DX_MARGIN, x->down[REACH - 1] >> DX_MARGIN},
        .joined_after = {x->along[REACH + 1] >> DX_MARGIN, x->down[REACH + 1] >> DX_MARGIN}};

    for (int e = 0; e < 2; e++) {
        cross.inverse[e] = ends_of(x->inverse, p, &pairs[e]);
        directions_of(cross.direction[e], x, p, &pairs[e]);
    }
    s->gates.rows->smoother.slope(&x->row, &cross);
}

static void tell_row(const struct dx_smooth *s, struct dx_smooth_scratch *x,
                     const struct dx_geometry *g, uint32_t p, unsigned k)
{
    const struct dx_smooth_ends inverse = ends_of(x->inverse, p, &pairs[k]);
    struct dx_smooth_ends d[3];

    if (s->line) {
        s->gates.rows->smoother.even(
            &x->row, k, &inverse, s->line[(size_t)dx_area_row(&x->area, p) * DX_SMOOTH_PAIRS + k]);
        return;
    }
    directions_of(d, x, p, &pairs[k]);
    s->gates.rows->smoother.uneven(&x->row, k, &inverse, d, g->model == DX_MODEL_PINHOLE);
}

static void find_scale(const struct dx_smooth *s, struct dx_smooth_scratch *x, uint32_t p)
{
    const struct dx_smoother *rows = &s->gates.rows->smoother;
    const uint32_t *range = x->area.range[p] + DX_MARGIN;
    uint32_t sigma8[DX_SMOOTH_ROW];

    if (s->narrow)
        rows->noise(sigma8, range, &s->row_noise, x->row.n);
    for (uint32_t j = 0; !s->narrow && j < x->row.n; j++)
        sigma8[j] = dx_sigma_at(&s->gates.sigma, range[j]);
    rows->scale(&x->row, range, sigma8, (float)(s->noise / 256));
}

static void solve_row(const struct dx_smooth *s, struct dx_smooth_scratch *x,
                      const struct dx_geometry *g, uint32_t p)
{
    const struct dx_smoother *rows = &s->gates.rows->smoother;

    find_paths(x, p);
    find_scale(s, x, p);
    if (!s->line)
        find_slope(s, x, p);
    for (unsigned k = 0; k < DX_SMOOTH_PAIRS; k++) {
        tell_row(s, x, g, p, k);
        rows->weigh(&x->row, k, joined_by(x, &pairs[k]), pairs[k].weight);
    }
    rows->solve(&x->row, DX_SMOOTH_MAX_MOVE);
}

/* A range of 0 stays 0, no other becomes it, and each keeps to its width. */
static void move_narrow(uint16_t *restrict out, const uint32_t *range, const int32_t *move,
                        uint32_t n)
{
    for (uint32_t j = 0; j < n; j++) {
        const int32_t there = range[j] ? -1 : 0, to = (int32_t)range[j] - move[j];
        const int32_t least = to > 1 ? to : 1, most = least < UINT16_MAX ? least : UINT16_MAX;

        out[j] = (uint16_t)(most & there);
    }
}

static void move_wide(uint32_t *restrict out, const uint32_t *range, const int32_t *move,
                      uint32_t n)
{
    for (uint32_t j = 0; j < n; j++) {
        const int64_t to = (int64_t)range[j] - move[j];

        out[j] = range[j] == 0 ? 0 : to < 1 ? 1 : to > UINT32_MAX ? UINT32_MAX : (uint32_t)to;
    }
}

/* Replaces n elements of `size` bytes; widens col0..col1 of `changed`, from `col` on, by those that
 * differ. Whether any did. */
static bool replace(uint8_t *to, const uint8_t *from, size_t size, uint32_t n, uint32_t col,
                    struct dx_rect *changed)
{
    uint32_t first = 0, last = n - 1;

    if (memcmp(to, from, n * size) == 0)
        return false;
    while (memcmp(to + first * size, from + first * size, size) == 0)
        first++;
    while (memcmp(to + last * size, from + last * size, size) == 0)
        last--;
    memcpy(to, from, n * size);
    changed->col0 = changed->col0 < col + first ? changed->col0 : col + first;
    changed->col1 = changed->col1 > col + last ? changed->col1 : col + last;
    return true;
}

/* The dexels of a part in row i of the grid. */
static void put_row(struct dx_plane *out, struct dx_rect *changed, struct dx_smooth_scratch *x,
                    const struct dx_plane *in, const struct dx_rect *part, uint32_t i)
{
    const size_t at = (size_t)i * out->width + part->col0, rb = out->range_bytes;
    const uint32_t n = part->col1 - part->col0 + 1;
    const uint32_t *range = x->area.range[DX_MARGIN + i - part->row0] + DX_MARGIN;
    union {
        uint16_t narrow[DX_SMOOTH_ROW];
        uint32_t wide[DX_SMOOTH_ROW];
    } to;
    bool any;

    if (rb == 2)
        move_narrow(to.narrow, range, x->row.move, n);
    else
        move_wide(to.wide, range, x->row.move, n);
    any =
        replace((uint8_t *)out->range + at * rb, (const uint8_t *)&to, rb, n, part->col0, changed);
    if (out->attr_bytes)
        any |= replace((uint8_t *)out->attr + at * out->attr_bytes,
                       (const uint8_t *)in->attr + at * out->attr_bytes, out->attr_bytes, n,
                       part->col0, changed);
    if (any) {
        changed->row0 = changed->row0 < i ? changed->row0 : i;
        changed->row1 = i;
    }
}

/* ---- a part --------------------------------------------------------------------------------- */

static void gather(const struct dx_smooth *s, struct dx_smooth_scratch *x,
                   const struct dx_plane *in, const struct dx_tiling *tiling,
                   const struct dx_geometry *g, uint32_t tile)
{
    dx_area_gather(&x->area, in, tiling, g, &s->gates, tile / tiling->cols, tile % tiling->cols);
    dx_edges_join(&x->area, &s->gates, g);
    if (!x->area.wide)
        dx_area_widen(&x->area);
    invert(s, x);
    if (!s->line)
        gather_directions(x, g);
}

void dx_smooth_part(struct dx_smooth *s, struct dx_plane *out, struct dx_rect *changed,
                    const struct dx_plane *in, const struct dx_tiling *tiling,
                    const struct dx_geometry *g, uint32_t tile, unsigned thread)
{
    struct dx_smooth_scratch *x = &s->scratch[thread];
    const struct dx_rect part = dx_marks_part(tiling, tile);

    gather(s, x, in, tiling, g, tile);
    x->row.n = ((part.col1 - part.col0) / DX_SMOOTH_LANES + 1) * DX_SMOOTH_LANES;
    x->along[REACH] = x->down[REACH] = ~(dx_bits)0; /* every dexel is joined to itself */
    *changed = (struct dx_rect){.row0 = UINT32_MAX, .col0 = UINT32_MAX};
    for (uint32_t i = part.row0; i <= part.row1; i++) {
        solve_row(s, x, g, DX_MARGIN + i - part.row0);
        put_row(out, changed, x, in, &part, i);
    }
}
