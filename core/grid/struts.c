/* Struts of a tile: first which way each missing dexel is spanned, then what lies beside. */
#include "core/grid/struts.h"

#include "core/base/bytes.h"

#include <string.h>

/* A way to be spanned: one more than DX_SPAN(across, len) * 2 + place in the run (0 or 1). */
#define NOT_SPANNED 0

static uint8_t span_of(bool across, uint8_t len, unsigned place)
{
    return (uint8_t)(1 + DX_SPAN(across, len) * 2 + place);
}

/* A run of missing dexels: its first one, and the steps along it and to its side t = +1. */
struct run {
    uint32_t p, q;
    bool across;
    uint8_t len;
};

struct place {
    uint32_t p, q;
};

/* Position (along, t) of a run. */
static struct place at(const struct run *r, int along, int t)
{
    return r->across ? (struct place){r->p + (uint32_t)t, r->q + (uint32_t)along}
                     : (struct place){r->p + (uint32_t)along, r->q + (uint32_t)t};
}

static uint32_t range_at(const struct dx_area *a, struct place x)
{
    return dx_area_range(a, x.p, x.q);
}

static uint32_t difference(const struct dx_area *a, struct place x, struct place y)
{
    uint32_t r = range_at(a, x), s = range_at(a, y);

    return r < s ? s - r : r - s;
}

static bool within_cap(const struct dx_area *a, const struct dx_gates *gates, struct place x,
                       struct place y)
{
    return dx_area_within_cap(a, gates, x.p, x.q, y.p, y.q);
}

/* ---- which way ------------------------------------------------------------------------------ */

/* The run through a missing dexel: false when it is longer than a strut may be. */
static bool find_run(struct run *r, const struct dx_area *a, uint8_t bridge, uint32_t p, uint32_t q,
                     bool across)
{
    *r = (struct run){p, q, across, 1};
    if (!range_at(a, at(r, -1, 0))) {
        r->p -= !across;
        r->q -= across;
        r->len = 2;
    } else if (!range_at(a, at(r, 1, 0))) {
        r->len = 2;
    }
    return r->len <= bridge && range_at(a, at(r, -1, 0)) && range_at(a, at(r, r->len, 0));
}

/* Whether a strut may span the run: its ends are such neighbours as a surface has. */
static bool can_span(const struct run *r, const struct dx_area *a, const struct dx_gates *gates,
                     const struct dx_geometry *g)
{
    const struct place begin = at(r, -1, 0), end = at(r, r->len, 0);
    uint32_t row = dx_area_row(a, r->p), col = dx_area_col(a, r->q, g->width);

    return a->alive[begin.p][begin.q] && a->alive[end.p][end.q] &&
           dx_gates_pass(gates, range_at(a, begin), range_at(a, end),
                         dx_gates_span(gates, g, r->across, r->len, row, col)) &&
           within_cap(a, gates, begin, end) &&
           dx_gates_faces(gates, g, r->across, r->len, row, col);
}

static uint8_t choose(const struct dx_area *a, const struct dx_gates *gates,
                      const struct dx_geometry *g, uint32_t p, uint32_t q)
{
    const struct run *best = NULL;
    struct run run[2];

    for (unsigned across = 0; across < 2; across++) {
        struct run *r = &run[across];

        if (!find_run(r, a, gates->bridge, p, q, across) || !can_span(r, a, gates, g))
            continue;
        if (!best || r->len < best->len ||
            (r->len == best->len && difference(a, at(r, -1, 0), at(r, r->len, 0)) <
                                        difference(a, at(best, -1, 0), at(best, best->len, 0))))
            best = r;
    }
    return best ? span_of(best->across, best->len, p != best->p || q != best->q) : NOT_SPANNED;
}

/* Missing dexels of the tile and one around it: what a strut's neighbour has chosen. Outside the
 * grid: without ends to span from. */
static void choose_all(struct dx_spans *s, const struct dx_area *a, const struct dx_gates *gates,
                       const struct dx_geometry *g)
{
    const uint32_t before = gates->bridge > 1; /* only struts over two look back */
    const uint32_t end = DX_MARGIN + a->n_rows + 2, right = DX_MARGIN + a->n_cols + 2;

    for (uint32_t p = DX_MARGIN - before; p < end; p++) {
        const uint8_t *const valid[3] = {a->valid[p - 1], a->valid[p], a->valid[p + 1]};
        struct dx_row_missing *missing = &s->missing[p];
        const bool in_grid = a->row0 + p >= 0 && a->row0 + p < g->height;

        memset(s->at[p], NOT_SPANNED, sizeof(s->at[p]));
        gates->rows->missing(missing, valid, gates->bridge > 1);
        if (!missing->has_crowded || !in_grid)
            continue;
        for (uint32_t q = DX_MARGIN - before; q < right; q += 8)
            for (uint64_t out = dx_get_u64(missing->crowded + q); out; out &= out - 1) {
                const uint32_t k = q + (uint32_t)__builtin_ctzll(out) / 8;

                s->at[p][k] = choose(a, gates, g, p, k);
            }
    }
}

/* The length of the strut in this direction whose first missing dexel it is; 0: there is none.
 * Both dexels of a run of two must have chosen it. */
static uint8_t strut_at(const struct dx_spans *s, struct place x, bool across)
{
    for (uint8_t len = 1; len <= 2; len++)
        if (s->at[x.p][x.q] == span_of(across, len, 0) &&
            (len == 1 || s->at[x.p + !across][x.q + across] == span_of(across, len, 1)))
            return len;
    return 0;
}

/* ---- what lies beside ----------------------------------------------------------------------- */

/* The final edge between two dexels that are corners of one cell. */
static bool edge_between(const struct dx_area *a, struct place x, struct place y)
{
    if (x.p > y.p || (x.p == y.p && x.q > y.q)) {
        struct place z = x;

        x = y;
        y = z;
    }
    if (x.p == y.p)
        return dx_area_edge(a, DX_EDGE_H, x.p, x.q);
    if (x.q == y.q)
        return dx_area_edge(a, DX_EDGE_V, x.p, x.q);
    return x.q < y.q ? dx_area_edge(a, DX_EDGE_AC, x.p, x.q)
                     : dx_area_edge(a, DX_EDGE_BD, x.p, y.q);
}

/* The side code of a quadrilateral: cut from A, or (one more) from B. */
static uint8_t cut(uint8_t side, const struct run *r, const struct dx_area *a,
                   const struct dx_gates *gates, struct place side0, struct place side1)
{
    const struct place begin = at(r, -1, 0), end = at(r, r->len, 0);
    const bool from_begin = difference(a, begin, side1) <= difference(a, end, side0);
    const bool begin_fits = within_cap(a, gates, begin, side1);
    const bool end_fits = within_cap(a, gates, end, side0);

    if (begin_fits && (from_begin || !end_fits))
        return side;
    return end_fits ? side + 1 : DX_STRUT_OPEN;
}

/* All dexels beside the run are there: they close the side when they hang together. */
static uint8_t chain_side(const struct run *r, const struct dx_area *a,
                          const struct dx_gates *gates, int t)
{
    const struct place first = at(r, 0, t), last = at(r, r->len - 1, t);

    if (!edge_between(a, at(r, -1, 0), first) || !edge_between(a, last, at(r, r->len, 0)))
        return DX_STRUT_OPEN;
    if (r->len == 1)
        return DX_STRUT_CHAIN;
    return edge_between(a, first, last) ? cut(DX_STRUT_CHAIN, r, a, gates, first, last)
                                        : DX_STRUT_OPEN;
}

/* The strut beside, where this run owns what lies between: the side, and where that strut's ends
 * are along this run. */
static uint8_t neighbour(int ends[2], const struct run *r, const struct dx_spans *s, int t)
{
    uint8_t len = strut_at(s, at(r, 0, t), r->across);

    if (t > 0 && len) {
        ends[0] = -1;
        ends[1] = len;
        return len == r->len ? DX_STRUT_EVEN : len > r->len ? DX_STRUT_LONGER : DX_STRUT_SHORTER;
    }
    if (r->len == 2 && strut_at(s, at(r, 1, t), r->across) == 1) {
        ends[0] = 0;
        ends[1] = 2;
        return DX_STRUT_LOWER;
    }
    return DX_STRUT_OPEN;
}

static uint8_t side_of(const struct run *r, const struct dx_spans *s, const struct dx_area *a,
                       const struct dx_gates *gates, int t)
{
    uint8_t side;
    int ends[2];

    if (range_at(a, at(r, 0, t)) && range_at(a, at(r, r->len - 1, t)))
        return chain_side(r, a, gates, t);
    side = neighbour(ends, r, s, t);
    if (side == DX_STRUT_OPEN || !edge_between(a, at(r, -1, 0), at(r, ends[0], t)) ||
        !edge_between(a, at(r, r->len, 0), at(r, ends[1], t)))
        return DX_STRUT_OPEN;
    return cut(side, r, a, gates, at(r, ends[0], t), at(r, ends[1], t));
}

static uint8_t code_of(const struct dx_spans *s, const struct dx_area *a,
                       const struct dx_gates *gates, uint32_t p, uint32_t q)
{
    for (unsigned across = 0; across < 2; across++) {
        struct run r = {p, q, across, strut_at(s, (struct place){p, q}, across)};
        struct dx_strut strut = {.across = across, .len = r.len};

        if (!r.len)
            continue;
        strut.first = side_of(&r, s, a, gates, -1);
        strut.second = side_of(&r, s, a, gates, 1);
        return strut.first || strut.second ? dx_strut_code(&strut) : 0;
    }
    return 0;
}

/* ---- a missing dexel among four ------------------------------------------------------------- */

/* The constants of struts over one dexel of a row, down and across. */
struct lone_row {
    uint32_t c[2];
    bool faces[2];
};

static struct lone_row lone_row(const struct dx_area *a, const struct dx_gates *gates,
                                const struct dx_geometry *g, uint32_t p, uint32_t q)
{
    const uint32_t row = dx_area_row(a, p), col = dx_area_col(a, q, g->width);
    struct lone_row r;

    for (unsigned across = 0; across < 2; across++) {
        r.c[across] = dx_gates_span(gates, g, across, 1, row, col);
        r.faces[across] = dx_gates_faces(gates, g, across, 1, row, col);
    }
    return r;
}

/* Most drop-outs are lone: nothing that is spanned lies beside, so that the four edges around tell.
 * As few branches as may be: each of them would be a coin toss. */
static uint8_t code_alone(const struct dx_area *a, const struct dx_gates *gates,
                          const struct lone_row *row, uint32_t p, uint32_t q)
{
    const bool nw = dx_area_edge(a, DX_EDGE_BD, p - 1, q - 1);
    const bool ne = dx_area_edge(a, DX_EDGE_AC, p - 1, q);
    const bool sw = dx_area_edge(a, DX_EDGE_AC, p, q - 1), se = dx_area_edge(a, DX_EDGE_BD, p, q);
    const struct place n = {p - 1, q}, s = {p + 1, q}, w = {p, q - 1}, e = {p, q + 1};
    bool down = a->alive[p - 1][q] & a->alive[p + 1][q] & row->faces[0] &
                dx_gates_pass(gates, range_at(a, n), range_at(a, s), row->c[0]);
    bool across = a->alive[p][q - 1] & a->alive[p][q + 1] & row->faces[1] &
                  dx_gates_pass(gates, range_at(a, w), range_at(a, e), row->c[1]);
    struct dx_strut strut = {.len = 1};

    if (gates->cap) {
        down = down && within_cap(a, gates, n, s);
        across = across && within_cap(a, gates, w, e);
    }
    strut.across = across & (!down | (difference(a, w, e) < difference(a, n, s)));
    strut.first = nw & (strut.across ? ne : sw); /* DX_STRUT_CHAIN or _OPEN */
    strut.second = se & (strut.across ? sw : ne);
    return (down | across) & (strut.first | strut.second) ? dx_strut_code(&strut) : 0;
}

/* ---- rows ----------------------------------------------------------------------------------- */

/* The first `cols` dexels of the tile's row i. */
static void code_lone(uint8_t *strut, const struct dx_spans *spans, const struct dx_area *a,
                      const struct dx_gates *gates, const struct dx_geometry *g, uint32_t i,
                      uint32_t cols)
{
    const uint32_t p = DX_MARGIN + i;
    struct lone_row row;
    bool has_row = false;

    for (uint32_t j = 0; j < cols; j += 8)
        for (uint64_t lone = dx_get_u64(spans->missing[p].lone + DX_MARGIN + j); lone;
             lone &= lone - 1) {
            const uint32_t k = j + (uint32_t)__builtin_ctzll(lone) / 8;

            if (k >= cols)
                break;
            if (!has_row || gates->per_dexel)
                row = lone_row(a, gates, g, p, DX_MARGIN + k);
            has_row = true;
            strut[k] = code_alone(a, gates, &row, p, DX_MARGIN + k);
        }
}

static void code_spanned(uint8_t *strut, const struct dx_spans *spans, const struct dx_area *a,
                         const struct dx_gates *gates, uint32_t i, uint32_t cols)
{
    const uint32_t p = DX_MARGIN + i;

    for (uint32_t j = 0; j < cols; j += 8)
        if (dx_get_u64(spans->at[p] + DX_MARGIN + j))
            for (uint32_t k = j; k < j + 8 && k < cols; k++)
                if (spans->at[p][DX_MARGIN + k])
                    strut[k] = code_of(spans, a, gates, p, DX_MARGIN + k);
}

void dx_struts_code(uint8_t strut[DX_BLOCK_DEXELS], struct dx_spans *spans, const struct dx_area *a,
                    const struct dx_gates *gates, const struct dx_geometry *g,
                    const struct dx_tiling *tiling)
{
    /* The last tiles own the grid's last row and column of dexels too, which no cell begins at. */
    uint32_t rows = a->n_rows + (a->row0 + DX_MARGIN + a->n_rows + 1 == tiling->height);
    uint32_t cols =
        a->n_cols + (!tiling->wrap && a->col0 + DX_MARGIN + a->n_cols + 1 == tiling->width);

    memset(strut, 0, DX_BLOCK_DEXELS);
    if (gates->bridge == 0)
        return;
    choose_all(spans, a, gates, g);
    for (uint32_t i = 0; i < rows; i++) {
        const struct dx_row_missing *missing = &spans->missing[DX_MARGIN + i];
        uint8_t *out = strut + (i + 1) * DX_BLOCK + 1;

        if (missing->has_crowded)
            code_spanned(out, spans, a, gates, i, cols);
        if (missing->has_lone)
            code_lone(out, spans, a, gates, g, i, cols);
    }
}
