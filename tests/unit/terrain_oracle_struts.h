/*
 * The oracle of terrain mode, third part: struts over missing dexels, each from its own positions
 * (docs/terrain.md). Places along a strut: its missing dexels are 0 .. len-1, its ends A = -1 and
 * B = len; places across: 0 on the strut, -1 and +1 beside it. cmocka.h comes before.
 */
#ifndef DX_TERRAIN_ORACLE_STRUTS_H
#define DX_TERRAIN_ORACLE_STRUTS_H

#include "core/grid/strut.h"
#include "terrain_fixture.h"
#include "terrain_oracle_frame.h"

enum strut_choice { CHOICE_NONE, CHOICE_DOWN, CHOICE_ACROSS };

/* A run of missing dexels; (i,j) is the first. */
struct run {
    int64_t i, j;
    int len;
    bool across;
};

/* The triangles that struts of one direction and length can make, and the places of a side. */
struct strut_shapes {
    struct dx_strut_corner corner[2][2][DX_STRUT_CODES * DX_STRUT_MAX_TRIANGLES][3];
    unsigned n[2][2];
};

static inline int64_t row_of(const struct run *r, int place, int t)
{
    return r->i + (r->across ? t : place);
}

static inline int64_t col_of(const struct run *r, int place, int t)
{
    return r->j + (r->across ? place : t);
}

static inline int64_t place_of(const struct oracle *o, const struct run *r, int place, int t)
{
    return dexel(o, row_of(r, place, t), col_of(r, place, t));
}

static inline bool edge_of(const struct oracle *o, const struct run *r, int place0, int t0,
                           int place1, int t1)
{
    return is_edge(o, row_of(r, place0, t0), col_of(r, place0, t0), row_of(r, place1, t1),
                   col_of(r, place1, t1));
}

static inline bool is_missing(const struct oracle *o, int64_t k)
{
    return k >= 0 && range_at(o, k) == 0;
}

/* The run through the missing dexel (i,j), up to the longest that is bridged. */
static inline bool find_run(const struct oracle *o, struct run *r, int64_t i, int64_t j,
                            bool across)
{
    *r = (struct run){i, j, 1, across};
    while (is_missing(o, place_of(o, r, -1, 0))) {
        if (++r->len > o->q.bridge)
            return false;
        r->i = row_of(r, across ? 0 : -1, 0);
        r->j = col_of(r, across ? -1 : 0, 0);
    }
    while (is_missing(o, place_of(o, r, r->len, 0)))
        if (++r->len > o->q.bridge)
            return false;
    return true;
}

/* ---- which dexels have a strut --------------------------------------------------------------- */

static inline bool has_shape(const struct strut_shapes *s, bool across, int len,
                             const struct dx_strut_corner corner[3])
{
    for (unsigned k = 0; k < s->n[across][len - 1]; k++)
        if (memcmp(s->corner[across][len - 1][k], corner, 3 * sizeof(*corner)) == 0)
            return true;
    return false;
}

static inline void strut_shapes_init(struct strut_shapes *s)
{
    memset(s, 0, sizeof(*s));
    for (unsigned code = 1; code < DX_STRUT_CODES; code++) {
        struct dx_strut_corner corner[DX_STRUT_MAX_TRIANGLES][3];
        unsigned n = dx_strut_triangles(corner, (uint8_t)code);
        struct dx_strut strut;

        if (!dx_strut_decode(&strut, (uint8_t)code))
            continue;
        for (unsigned k = 0; k < n; k++)
            if (!has_shape(s, strut.across, strut.len, corner[k]))
                memcpy(s->corner[strut.across][strut.len - 1][s->n[strut.across][strut.len - 1]++],
                       corner[k], sizeof(corner[k]));
    }
}

/*
 * Whether a triangle sees the scanner, by a margin: the plane through its directions is more than
 * half a unit away. Where one is seen edge-on, the rounding of the tables would decide; and on even
 * grids one column speaks for all.
 */
static inline bool sees_scanner(const struct oracle *o, const int64_t v[3], double distance)
{
    const uint32_t w = o->g->width;
    double d[3][3], x[3], y[3], n[3], det;

    for (int m = 0; m < 3; m++)
        dx_geometry_direction(o->g, (uint32_t)(v[m] / w), (uint32_t)(v[m] % w), d[m]);
    for (int k = 0; k < 3; k++) {
        x[k] = d[1][k] - d[0][k];
        y[k] = d[2][k] - d[0][k];
    }
    n[0] = x[1] * y[2] - x[2] * y[1];
    n[1] = x[2] * y[0] - x[0] * y[2];
    n[2] = x[0] * y[1] - x[1] * y[0];
    det = o->g->flip ? dot(d[0], n) : -dot(d[0], n);
    return det > 0 && det * det > distance * distance * dot(n, n);
}

/* Whether all that a strut of this direction and length can make here would see the scanner. */
static inline bool faces(const struct oracle *o, const struct strut_shapes *s, const struct run *r)
{
    const int64_t col = o->uneven || o->g->width < 3 ? r->j : 1;

    for (unsigned k = 0; k < s->n[r->across][r->len - 1]; k++) {
        const struct dx_strut_corner *c = s->corner[r->across][r->len - 1][k];
        int64_t v[3];

        for (int m = 0; m < 3; m++)
            v[m] = dexel(o, r->i + c[m].row, col + c[m].col);
        if (v[0] >= 0 && v[1] >= 0 && v[2] >= 0 && !sees_scanner(o, v, 0.5))
            return false;
    }
    return true;
}

static inline int64_t span_constant(const struct oracle *o, const struct run *r)
{
    struct run at = *r;

    if (!o->uneven)
        at.j = r->across ? 1 : 0;
    return gate_constant(o, oracle_psi(o, place_of(o, &at, -1, 0), place_of(o, &at, at.len, 0)),
                         o->q.tilt_deg);
}

/* A run that could be spanned. */
static inline bool is_available(const struct oracle *o, const struct strut_shapes *s, struct run *r,
                                int64_t i, int64_t j, bool across)
{
    int64_t a, b;

    if (!find_run(o, r, i, j, across))
        return false;
    a = place_of(o, r, -1, 0);
    b = place_of(o, r, r->len, 0);
    return a >= 0 && b >= 0 && !o->dead[a] && !o->dead[b] &&
           within_gate(o, a, b, span_constant(o, r)) && within_cap(o, a, b) && faces(o, s, r);
}

static inline wide span_rise(const struct oracle *o, const struct run *r)
{
    return apart(o, place_of(o, r, -1, 0), place_of(o, r, r->len, 0));
}

static inline enum strut_choice decide_choice(const struct oracle *o, const struct strut_shapes *s,
                                              int64_t i, int64_t j)
{
    struct run down, across;
    bool has_down, has_across;

    if (!is_missing(o, dexel(o, i, j)) || o->q.bridge == 0)
        return CHOICE_NONE;
    has_down = is_available(o, s, &down, i, j, false);
    has_across = is_available(o, s, &across, i, j, true);
    if (!has_down || !has_across)
        return has_down ? CHOICE_DOWN : has_across ? CHOICE_ACROSS : CHOICE_NONE;
    if (down.len != across.len)
        return down.len < across.len ? CHOICE_DOWN : CHOICE_ACROSS;
    return span_rise(o, &down) <= span_rise(o, &across) ? CHOICE_DOWN : CHOICE_ACROSS;
}

static inline void oracle_choose(struct oracle *o)
{
    struct strut_shapes *s = malloc(sizeof(*s));
    const uint32_t w = o->g->width;

    assert_non_null(s);
    strut_shapes_init(s);
    for (size_t k = 0; k < o->n; k++)
        o->choice[k] = (uint8_t)decide_choice(o, s, (int64_t)k / w, (int64_t)k % w);
    free(s);
}

/* A run whose dexels all chose it. */
static inline bool has_strut(const struct oracle *o, const struct run *r)
{
    for (int s = 0; s < r->len; s++)
        if (o->choice[place_of(o, r, s, 0)] != (r->across ? CHOICE_ACROSS : CHOICE_DOWN))
            return false;
    return true;
}

/* ---- what a strut makes ---------------------------------------------------------------------- */

/* A corner of a polygon beside a strut. */
struct corner {
    int place, t;
};

/* A triangle, turned so that its area in the index plane is positive: rows down, columns right. */
static inline void emit_corners(const struct oracle *o, struct whole_mesh *w, const struct run *r,
                                struct corner x, struct corner y, struct corner z)
{
    const struct corner c[3] = {x, y, z};
    int64_t row[3], col[3], v[3];
    bool turn;

    for (int m = 0; m < 3; m++) {
        row[m] = row_of(r, c[m].place, c[m].t);
        col[m] = col_of(r, c[m].place, c[m].t);
        v[m] = dexel(o, row[m], col[m]);
    }
    turn = (col[1] - col[0]) * (row[2] - row[0]) < (col[2] - col[0]) * (row[1] - row[0]);
    if (turn != o->g->flip)
        w->triangle[w->n++] = rotated((uint32_t)v[0], (uint32_t)v[2], (uint32_t)v[1]);
    else
        w->triangle[w->n++] = rotated((uint32_t)v[0], (uint32_t)v[1], (uint32_t)v[2]);
}

/* The quadrilateral A, x, y, B: cut from A to y or from B to x, by the smaller difference of range,
 * A's on ties; with a cap, by one that is within it. */
static inline void emit_quad(const struct oracle *o, struct whole_mesh *w, const struct run *r,
                             struct corner x, struct corner y)
{
    const struct corner a = {-1, 0}, b = {r->len, 0};
    const int64_t ka = place_of(o, r, -1, 0), kb = place_of(o, r, r->len, 0);
    const int64_t kx = place_of(o, r, x.place, x.t), ky = place_of(o, r, y.place, y.t);
    const bool can_a = within_cap(o, ka, ky), can_b = within_cap(o, kb, kx);

    if (can_a && (apart(o, ka, ky) <= apart(o, kb, kx) || !can_b)) {
        emit_corners(o, w, r, a, x, y);
        emit_corners(o, w, r, a, y, b);
    } else if (can_b) {
        emit_corners(o, w, r, a, x, b);
        emit_corners(o, w, r, x, y, b);
    }
}

static inline void emit_chain(const struct oracle *o, struct whole_mesh *w, const struct run *r,
                              int t)
{
    const struct corner first = {0, t}, last = {r->len - 1, t};

    if (!edge_of(o, r, -1, 0, 0, t) || !edge_of(o, r, r->len - 1, t, r->len, 0))
        return;
    if (r->len == 1)
        emit_corners(o, w, r, (struct corner){-1, 0}, first, (struct corner){1, 0});
    else if (edge_of(o, r, 0, t, 1, t))
        emit_quad(o, w, r, first, last);
}

/* The strut beside r at t that it may be bridged to; its places on r's scale are first .. last.
 * False: none. There is never a second one. */
static inline bool find_beside(const struct oracle *o, const struct run *r, int t, int *first,
                               int *last)
{
    int n = 0;

    for (int s = 0; s < r->len; s++) {
        struct run other;
        int top, end;

        if (!is_missing(o, place_of(o, r, s, t)) ||
            !find_run(o, &other, row_of(r, s, t), col_of(r, s, t), r->across) ||
            !has_strut(o, &other))
            continue;
        top = (int)(r->across ? other.j - r->j : other.i - r->i);
        end = top + other.len - 1;
        if (abs(top) > 1 || abs(end - (r->len - 1)) > 1 ||
            (end > r->len - 1 ? end : r->len - 1) - (top < 0 ? top : 0) > 1)
            continue;
        assert_true(n == 0 || (*first == top && *last == end));
        *first = top;
        *last = end;
        n++;
    }
    return n > 0;
}

static inline void emit_bridge(const struct oracle *o, struct whole_mesh *w, const struct run *r,
                               int t)
{
    int first = 0, last = 0;

    if (!find_beside(o, r, t, &first, &last) || first < 0 || (first == 0 && t < 0))
        return; /* none, or the other one's */
    if (edge_of(o, r, -1, 0, first - 1, t) && edge_of(o, r, r->len, 0, last + 1, t))
        emit_quad(o, w, r, (struct corner){first - 1, t}, (struct corner){last + 1, t});
}

static inline void emit_strut(const struct oracle *o, struct whole_mesh *w, int64_t i, int64_t j)
{
    const int64_t k = dexel(o, i, j);
    struct run r;

    if (o->choice[k] == CHOICE_NONE || !find_run(o, &r, i, j, o->choice[k] == CHOICE_ACROSS) ||
        place_of(o, &r, 0, 0) != k || !has_strut(o, &r))
        return;
    for (int t = -1; t <= 1; t += 2) {
        bool all = true;

        for (int s = 0; s < r.len; s++)
            all = all && range_at(o, place_of(o, &r, s, t));
        if (all)
            emit_chain(o, w, &r, t);
        else
            emit_bridge(o, w, &r, t);
    }
}

#endif
