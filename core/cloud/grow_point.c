/* GET_POINT: the candidates for a border edge, and which of them it is. */
#include "core/cloud/grow_priv.h"

#include <math.h>

#define MAX_CAND   (2 * DX_GROW_K)
#define N_MEAN     6   /* neighbours whose mean distance tells how far points are */
#define MEAN_RATIO 2.5 /* of later rounds: the longest edge to it */
#define NONE       DX_NO_HALFEDGE

struct candidate {
    uint32_t t, bend; /* which of cos_bend */
    double cos_apex;  /* of the angle at which it sees the edge */
    double len;
    bool gone;
};

/* The edge (u, v), and s across from it. */
struct edge {
    uint32_t b, u, v, s;
    double uv[3], len, normal[3];
    double reach;
};

static double distance(const struct dx_grow_run *run, uint32_t a, uint32_t b)
{
    double d[3];

    dx_grow_between(d, run, a, b);
    return sqrt(dx_grow_dot(d, d));
}

static double mean_distance(const struct dx_grow_run *run, uint32_t v)
{
    const uint32_t *near = dx_neighbours_of(run->nb, v);
    const uint32_t n = run->nb->k < N_MEAN ? run->nb->k : N_MEAN;
    double sum = 0;

    for (uint32_t k = 0; k < n; k++)
        sum += distance(run, v, near[k]);
    return n ? sum / n : 0;
}

/* First as printed. A pair of points that nearly meet makes that short; so later by the mean. */
double dx_grow_reach(const struct dx_grow_run *run, uint32_t u, uint32_t v)
{
    double du, dv;

    if (run->round == 0) {
        du = distance(run, u, dx_neighbours_of(run->nb, u)[0]);
        dv = distance(run, v, dx_neighbours_of(run->nb, v)[0]);
        return run->config->max_ratio * (du < dv ? du : dv);
    }
    du = mean_distance(run, u);
    dv = mean_distance(run, v);
    return MEAN_RATIO * (du < dv ? du : dv);
}

/* A triangle that stands on the surface would lead to another sheet. */
static bool leans(const struct dx_grow_run *run, uint32_t v, const double n[3])
{
    const float *of = run->config->normal ? run->config->normal[v] : NULL;
    double dot = 0, len2 = 0;

    for (int k = 0; k < 3 && of; k++) {
        dot += (double)of[k] * n[k];
        len2 += (double)of[k] * (double)of[k];
    }
    return len2 > 0 && fabs(dot) < run->cos_lean;
}

/* Conditions (i), (iii) and (iv); false: one does not hold. */
static bool measure(struct candidate *c, const struct dx_grow_run *run, const struct edge *e,
                    uint32_t t)
{
    double ut[3], vt[3], n[3], ut_len, vt_len, cos_bend, at_u, at_v;

    dx_grow_between(ut, run, e->u, t);
    dx_grow_between(vt, run, e->v, t);
    ut_len = sqrt(dx_grow_dot(ut, ut));
    vt_len = sqrt(dx_grow_dot(vt, vt));
    if (!((ut_len > vt_len ? ut_len : vt_len) < e->reach))
        return false;
    at_u = dx_grow_dot(ut, e->uv) / (ut_len * e->len);
    at_v = -dx_grow_dot(vt, e->uv) / (vt_len * e->len);
    if (!(at_u > run->cos_angle && at_v > run->cos_angle))
        return false;
    dx_grow_face_normal(n, run, e->u, e->v, t);
    cos_bend = dx_grow_dot(n, e->normal);
    if (dx_grow_dot(n, n) == 0 || leans(run, e->u, n) || leans(run, e->v, n) || leans(run, t, n))
        return false;
    *c = (struct candidate){t, 0, dx_grow_dot(ut, vt) / (ut_len * vt_len), ut_len + vt_len, false};
    while (c->bend < run->n_bends && !(cos_bend >= run->cos_bend[c->bend]))
        c->bend++;
    return c->bend < run->n_bends;
}

/* Of K(u) and K(v), those that may be joined. */
static uint32_t collect(struct candidate *out, const struct dx_grow_run *run, const struct edge *e)
{
    const uint32_t k = run->nb->k < DX_GROW_K ? run->nb->k : DX_GROW_K;
    uint32_t n = 0;

    for (uint32_t i = 0; i < 2 * k; i++) {
        const uint32_t t = dx_neighbours_of(run->nb, i < k ? e->u : e->v)[i < k ? i : i - k];
        bool seen = t == e->u || t == e->v || t == e->s;

        for (uint32_t j = 0; j < n && !seen; j++)
            seen = out[j].t == t;
        if (seen || (dx_grow_is_used(run, t) && dx_halfedge_corner(run->mesh, t) == NONE))
            continue;
        n += measure(&out[n], run, e, t);
    }
    return n;
}

static bool is_better(const struct candidate *a, const struct candidate *b)
{
    if (a->bend != b->bend)
        return a->bend < b->bend;
    if (a->cos_apex != b->cos_apex)
        return a->cos_apex < b->cos_apex;
    return a->len != b->len ? a->len < b->len : a->t < b->t;
}

/* Condition (ii). */
static bool may_join(const struct dx_grow_run *run, const struct edge *e, uint32_t t,
                     uint32_t *corner)
{
    const uint32_t v[3] = {e->u, e->v, t};

    *corner = NONE;
    if (dx_grow_is_used(run, t))
        *corner = dx_grow_gap(run, t, e->u, e->v);
    return dx_halfedge_fits(run->mesh, e->b, t, *corner) && dx_grow_is_clear(run, v, false);
}

/* The triangle of e and t, seen along its normal, has point q inside. */
static bool covers(const struct dx_grow_run *run, const struct edge *e, uint32_t t, uint32_t q)
{
    const uint32_t v[3] = {e->u, e->v, t};
    double n[3];

    dx_grow_face_normal(n, run, v[0], v[1], v[2]);
    for (int k = 0; k < 3; k++) {
        double side[3], to_q[3], out[3];

        dx_grow_between(side, run, v[k], v[(k + 1) % 3]);
        dx_grow_between(to_q, run, v[k], q);
        dx_grow_cross(out, side, to_q);
        if (!(dx_grow_dot(out, n) > 0))
            return false;
    }
    return true;
}

/* One of the other candidates that no triangle has yet is under the triangle: it would stay so. */
static bool covers_any(const struct dx_grow_run *run, const struct edge *e, uint32_t t,
                       const struct candidate *c, uint32_t n)
{
    for (uint32_t k = 0; k < n; k++)
        if (c[k].t != t && !c[k].gone && !dx_grow_is_used(run, c[k].t) && covers(run, e, t, c[k].t))
            return true;
    return false;
}

uint32_t dx_grow_point(const struct dx_grow_run *run, uint32_t b, uint32_t *corner)
{
    struct edge e = {.b = b, .u = dx_halfedge_from(run->mesh, b), .v = run->mesh->of[b].to};
    struct candidate c[MAX_CAND];
    uint32_t n;

    e.s = dx_halfedge_apex(run->mesh, b ^ 1);
    dx_grow_between(e.uv, run, e.u, e.v);
    e.len = sqrt(dx_grow_dot(e.uv, e.uv));
    dx_grow_face_normal(e.normal, run, e.v, e.u, e.s);
    e.reach = dx_grow_reach(run, e.u, e.v);
    n = collect(c, run, &e);
    for (;;) {
        struct candidate *best = NULL;

        for (uint32_t k = 0; k < n; k++)
            if (!c[k].gone && (!best || is_better(&c[k], best)))
                best = &c[k];
        if (!best)
            return NONE;
        if (!covers_any(run, &e, best->t, c, n) && may_join(run, &e, best->t, corner))
            return best->t;
        best->gone = true;
    }
}
