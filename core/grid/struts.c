/* Struts of a tile: first which way each missing dexel is spanned, then what lies beside. */
#include "core/grid/struts.h"

/* A way to be spanned, and the place in the run (0 or 1). */
static uint8_t span_of(bool across, uint8_t len, unsigned place)
{
    return (uint8_t)(DX_SPAN(across, len) * 2 + place);
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

    return dx_bits_at(dx_words_at(&a->alive, begin.p), begin.q) &&
           dx_bits_at(dx_words_at(&a->alive, end.p), end.q) &&
           dx_gates_pass(gates, range_at(a, begin), range_at(a, end),
                         dx_gates_span(gates, g, r->across, r->len, row, col)) &&
           within_cap(a, gates, begin, end) &&
           dx_gates_faces(gates, g, r->across, r->len, row, col);
}

/* False: no way. */
static bool choose(uint8_t *way, const struct dx_area *a, const struct dx_gates *gates,
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
    if (best)
        *way = span_of(best->across, best->len, p != best->p || q != best->q);
    return best;
}

/* Missing dexels of row p that may be spanned and are not lone ones: they have two ends opposite
 * each other, or, where two in a row are bridged, any. */
static dx_bits find_crowded(const struct dx_area *a, dx_bits lone, uint8_t bridge, uint32_t p)
{
    const dx_bits above = dx_words_at(&a->valid, p - 1), here = dx_words_at(&a->valid, p),
                  below = dx_words_at(&a->valid, p + 1);
    dx_bits ends = (above & below) | (here << 1 & here >> 1);

    if (bridge > 1)
        ends |= above | below | here << 1 | here >> 1;
    return ends & ~here & ~lone;
}

static dx_bits find_lone(const struct dx_area *a, uint32_t p)
{
    const dx_bits here = dx_words_at(&a->valid, p);

    return ~here & dx_words_at(&a->valid, p - 1) & dx_words_at(&a->valid, p + 1) & here << 1 &
           here >> 1;
}

static dx_bits choose_row(uint8_t way[DX_AREA_STRIDE], dx_bits crowded, const struct dx_area *a,
                          const struct dx_gates *gates, const struct dx_geometry *g, uint32_t p)
{
    dx_bits spanned = 0;

    for (; crowded; crowded &= crowded - 1) {
        const uint32_t q = dx_bits_first(crowded);

        spanned |= (dx_bits)choose(&way[q], a, gates, g, p, q) << q;
    }
    return spanned;
}

/* Missing dexels of the tile and one around it: what a strut's neighbour has chosen. Outside the
 * grid: without ends to span from. False: none is missing, and nothing is told. */
static bool choose_all(struct dx_spans *s, const struct dx_area *a, const struct dx_gates *gates,
                       const struct dx_geometry *g)
{
    const uint32_t before = gates->bridge > 1; /* only struts over two look back */
    const uint32_t end = DX_MARGIN + a->n_rows + 2, right = DX_MARGIN + a->n_cols + 2;
    const dx_bits columns = dx_bits_below(right) & ~dx_bits_below(DX_MARGIN - before);
    bool any = false;

    for (uint32_t p = DX_MARGIN - before; p < end; p++) {
        const bool in_grid = a->row0 + p >= 0 && a->row0 + p < g->height;

        s->lone[p] = s->spanned[p] = 0;
        if (!in_grid || !(~dx_words_at(&a->valid, p) & columns))
            continue;
        any = true;
        s->lone[p] = find_lone(a, p) & columns;
        s->spanned[p] = choose_row(
            s->at[p], find_crowded(a, s->lone[p], gates->bridge, p) & columns, a, gates, g, p);
    }
    return any;
}

static bool is_spanned(const struct dx_spans *s, struct place x, uint8_t way)
{
    return dx_bits_at(s->spanned[x.p], x.q) && s->at[x.p][x.q] == way;
}

/* The length of the strut in this direction whose first missing dexel it is; 0: there is none.
 * Both dexels of a run of two must have chosen it. */
static uint8_t strut_at(const struct dx_spans *s, struct place x, bool across)
{
    const struct place next = {x.p + !across, x.q + across};

    for (uint8_t len = 1; len <= 2; len++)
        if (is_spanned(s, x, span_of(across, len, 0)) &&
            (len == 1 || is_spanned(s, next, span_of(across, len, 1))))
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

/* What struts over one dexel of a row, down and across, have in common; and by columns: both ends
 * alive, and the sides that the edges around would close. */
struct lone_row {
    uint32_t c[2];
    bool faces[2];
    dx_bits ends[2], first[2], second[2];
};

static void find_constants(struct lone_row *r, const struct dx_gates *gates,
                           const struct dx_geometry *g, uint32_t row, uint32_t col)
{
    for (unsigned across = 0; across < 2; across++) {
        r->c[across] = dx_gates_span(gates, g, across, 1, row, col);
        r->faces[across] = dx_gates_faces(gates, g, across, 1, row, col);
    }
}

static void find_sides(struct lone_row *r, const struct dx_area *a, uint32_t p)
{
    const dx_bits nw = dx_words_at(&a->edge[DX_EDGE_BD], p - 1) << 1,
                  ne = dx_words_at(&a->edge[DX_EDGE_AC], p - 1);
    const dx_bits sw = dx_words_at(&a->edge[DX_EDGE_AC], p) << 1,
                  se = dx_words_at(&a->edge[DX_EDGE_BD], p);

    r->ends[0] = dx_words_at(&a->alive, p - 1) & dx_words_at(&a->alive, p + 1);
    r->ends[1] = dx_words_at(&a->alive, p) << 1 & dx_words_at(&a->alive, p) >> 1;
    r->first[0] = nw & sw;
    r->first[1] = nw & ne;
    r->second[0] = se & ne;
    r->second[1] = se & sw;
}

#define LONE(across, first, second) (uint8_t) DX_STRUT_CODE(across, 1, first, second)

/* By across, first, second. */
static const uint8_t lone_code[8] = {0, LONE(0, 0, 1), LONE(0, 1, 0), LONE(0, 1, 1),
                                     0, LONE(1, 0, 1), LONE(1, 1, 0), LONE(1, 1, 1)};

/* Most drop-outs are lone: nothing that is spanned lies beside, so that the four edges around tell.
 * As few branches as may be: each of them would be a coin toss. */
static uint8_t code_alone(const struct dx_area *a, const struct dx_gates *gates,
                          const struct lone_row *row, uint32_t p, uint32_t q)
{
    const struct place n = {p - 1, q}, s = {p + 1, q}, w = {p, q - 1}, e = {p, q + 1};
    const bool down_passes = dx_gates_pass(gates, range_at(a, n), range_at(a, s), row->c[0]);
    const bool across_passes = dx_gates_pass(gates, range_at(a, w), range_at(a, e), row->c[1]);
    bool down = dx_bits_at(row->ends[0], q) & row->faces[0] & down_passes;
    bool across = dx_bits_at(row->ends[1], q) & row->faces[1] & across_passes;
    unsigned sides;

    if (gates->cap) {
        down = down && within_cap(a, gates, n, s);
        across = across && within_cap(a, gates, w, e);
    }
    across = across & (!down | (difference(a, w, e) < difference(a, n, s)));
    sides = (unsigned)dx_bits_at(row->first[across], q) << 1 | dx_bits_at(row->second[across], q);
    return (down | across) ? lone_code[4 * across + sides] : 0;
}

/* ---- rows ----------------------------------------------------------------------------------- */

/* The tile's row i, whose lone dexels are those of `lone`. Whether there was a strut. */
static bool code_lone(uint8_t *strut, dx_bits lone, const struct dx_area *a,
                      const struct dx_gates *gates, const struct dx_geometry *g, uint32_t i)
{
    const uint32_t p = DX_MARGIN + i, row = dx_area_row(a, p);
    struct lone_row r;
    uint8_t some = 0;

    find_sides(&r, a, p);
    if (!gates->per_dexel)
        find_constants(&r, gates, g, row, 0);
    for (; lone; lone &= lone - 1) {
        const uint32_t q = dx_bits_first(lone);

        if (gates->per_dexel)
            find_constants(&r, gates, g, row, dx_area_col(a, q, g->width));
        some |= strut[q - DX_MARGIN] = code_alone(a, gates, &r, p, q);
    }
    return some;
}

static bool code_spanned(uint8_t *strut, const struct dx_spans *spans, dx_bits spanned,
                         const struct dx_area *a, const struct dx_gates *gates, uint32_t i)
{
    uint8_t some = 0;

    for (; spanned; spanned &= spanned - 1) {
        const uint32_t q = dx_bits_first(spanned);

        some |= strut[q - DX_MARGIN] = code_of(spans, a, gates, DX_MARGIN + i, q);
    }
    return some;
}

bool dx_struts_code(uint8_t strut[DX_BLOCK_DEXELS], struct dx_spans *spans, const struct dx_area *a,
                    const struct dx_gates *gates, const struct dx_geometry *g,
                    const struct dx_tiling *tiling)
{
    /* The last tiles own the grid's last row and column of dexels too, which no cell begins at. */
    uint32_t rows = a->n_rows + (a->row0 + DX_MARGIN + a->n_rows + 1 == tiling->height);
    uint32_t cols =
        a->n_cols + (!tiling->wrap && a->col0 + DX_MARGIN + a->n_cols + 1 == tiling->width);
    const dx_bits own = dx_bits_below(DX_MARGIN + cols) & ~dx_bits_below(DX_MARGIN);
    bool some = false;

    if (gates->bridge == 0 || !choose_all(spans, a, gates, g))
        return false;
    for (uint32_t i = 0; i < rows; i++) {
        const uint32_t p = DX_MARGIN + i;
        uint8_t *out = strut + (i + 1) * DX_BLOCK + 1;

        if (spans->spanned[p] & own)
            some |= code_spanned(out, spans, spans->spanned[p] & own, a, gates, i);
        if (spans->lone[p] & own)
            some |= code_lone(out, spans->lone[p] & own, a, gates, g, i);
    }
    return some;
}
