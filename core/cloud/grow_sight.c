/* Whether a triangle overlaps the mesh: projected on the tangent planes of the points around it,
 * beside their stars, in integers. */
#include "core/cloud/grow_priv.h"

#include "core/cloud/predicates.h"

#include <math.h>

#define SHEET    0.6       /* distance of sheets over the size of a star */
#define MAX_STAR 32        /* points around one that are looked at */
#define FLAT     (1 << 28) /* the farthest of them, in units of the plane */
#define NONE     DX_NO_HALFEDGE

/* A plane at point q, and what is projected on it. */
struct plane {
    uint32_t q;
    double u[3], v[3], normal[3];
    uint32_t n;
    double x[MAX_STAR + 3], y[MAX_STAR + 3], height[MAX_STAR + 3];
    struct dx_flat at[MAX_STAR + 3];
};

static bool set_plane(struct plane *p, const struct dx_grow_run *run, uint32_t q)
{
    const double *n = run->normal[q], len = sqrt(dx_grow_dot(n, n));
    const int k = fabs(n[0]) < fabs(n[1]) ? (fabs(n[0]) < fabs(n[2]) ? 0 : 2)
                                          : (fabs(n[1]) < fabs(n[2]) ? 1 : 2);
    double *unit = p->normal, u_len = 0;

    p->q = q;
    p->n = 0;
    if (!(len > 0))
        return false;
    for (int i = 0; i < 3; i++)
        unit[i] = n[i] / len;
    for (int i = 0; i < 3; i++) {
        p->u[i] = (i == k) - unit[k] * unit[i];
        u_len += p->u[i] * p->u[i];
    }
    for (int i = 0; i < 3; i++)
        p->u[i] /= sqrt(u_len);
    dx_grow_cross(p->v, unit, p->u);
    return true;
}

static void put(struct plane *p, const struct dx_grow_run *run, uint32_t v)
{
    double d[3];

    dx_grow_between(d, run, p->q, v);
    p->x[p->n] = dx_grow_dot(d, p->u);
    p->y[p->n] = dx_grow_dot(d, p->v);
    p->height[p->n] = dx_grow_dot(d, p->normal);
    p->n++;
}

/* To integers, when all are there. */
static void flatten(struct plane *p)
{
    double most = 0;

    for (uint32_t k = 0; k < p->n; k++) {
        most = fabs(p->x[k]) > most ? fabs(p->x[k]) : most;
        most = fabs(p->y[k]) > most ? fabs(p->y[k]) : most;
    }
    for (uint32_t k = 0; k < p->n; k++) {
        p->at[k].x = most > 0 ? (int32_t)rint(p->x[k] * (FLAT / most)) : 0;
        p->at[k].y = most > 0 ? (int32_t)rint(p->y[k] * (FLAT / most)) : 0;
    }
}

/* Turned to the left; false: it has no area. */
static bool turn_left(struct dx_flat t[3])
{
    const int64_t turn = dx_flat_turn(t[0], t[1], t[2]);

    if (turn < 0) {
        const struct dx_flat held = t[0];

        t[0] = t[1];
        t[1] = held;
    }
    return turn != 0;
}

/* No corner of b is on the left of one of a's edges. */
static bool is_parted(const struct dx_flat a[3], const struct dx_flat b[3])
{
    for (int k = 0; k < 3; k++) {
        const struct dx_flat from = a[k], to = a[(k + 1) % 3];

        if (dx_flat_turn(from, to, b[0]) <= 0 && dx_flat_turn(from, to, b[1]) <= 0 &&
            dx_flat_turn(from, to, b[2]) <= 0)
            return true;
    }
    return false;
}

/* The triangle (places 0 to 2) is so far above the star, or below, that it is of another sheet. */
static bool is_other_sheet(const struct plane *p)
{
    double least = fabs(p->height[0]), size2 = 0;

    for (int k = 1; k < 3; k++) {
        if (p->height[k] * p->height[0] <= 0)
            return false;
        least = fabs(p->height[k]) < least ? fabs(p->height[k]) : least;
    }
    for (uint32_t k = 3; k < p->n; k++) {
        const double d2 = p->x[k] * p->x[k] + p->y[k] * p->y[k];

        size2 = d2 > size2 ? d2 : size2;
    }
    return least * least > SHEET * SHEET * size2;
}

/* The star of q, with the triangle (places 0 to 2), in q's plane. */
static bool overlaps_star(const struct dx_grow_run *run, uint32_t q, const uint32_t v[3])
{
    const struct dx_halfedges *m = run->mesh;
    const uint32_t first = m->out[q];
    uint32_t h = first;
    bool is_face[MAX_STAR];
    struct dx_flat t[3];
    struct plane p;

    if (!set_plane(&p, run, q))
        return false;
    for (int k = 0; k < 3; k++)
        put(&p, run, v[k]);
    do {
        is_face[p.n - 3] = !dx_halfedge_is_border(m, h);
        put(&p, run, m->of[h].to);
        h = dx_halfedge_around(m, h);
    } while (h != first && p.n < MAX_STAR + 3);
    if (h != first) /* so many that one more is too many */
        return true;
    if (is_other_sheet(&p))
        return false;
    flatten(&p);
    for (int k = 0; k < 3; k++)
        t[k] = p.at[k];
    if (!turn_left(t))
        return false;
    for (uint32_t k = 3; k < p.n; k++) {
        /* a triangle lies between its half-edge and the next around */
        const uint32_t next = k + 1 < p.n ? k + 1 : 3;
        struct dx_flat s[3] = {{0, 0}, p.at[k], p.at[next]};

        if (is_face[k - 3] && turn_left(s) && !is_parted(s, t) && !is_parted(t, s))
            return true;
    }
    return false;
}

static bool is_one_of(const uint32_t v[3], uint32_t q)
{
    return q == v[0] || q == v[1] || q == v[2];
}

bool dx_grow_is_clear(const struct dx_grow_run *run, const uint32_t v[3], bool all)
{
    const uint32_t k = run->nb->k < DX_GROW_K ? run->nb->k : DX_GROW_K;

    for (int i = 0; i < 3; i++)
        if (dx_grow_is_used(run, v[i]) && overlaps_star(run, v[i], v))
            return false;
    for (uint32_t i = 0; i < 2 * k; i++) {
        const uint32_t q = dx_neighbours_of(run->nb, v[i / k])[i % k];

        if (is_one_of(v, q) || !dx_grow_is_used(run, q) ||
            (!all && dx_halfedge_corner(run->mesh, q) == NONE))
            continue;
        if (overlaps_star(run, q, v))
            return false;
    }
    return true;
}

uint32_t dx_grow_gap(const struct dx_grow_run *run, uint32_t q, uint32_t u, uint32_t v)
{
    const struct dx_halfedges *m = run->mesh;
    const uint32_t first = m->out[q];
    uint32_t h = first;

    do {
        struct plane p;

        if (dx_halfedge_is_border(m, h) && set_plane(&p, run, q)) {
            put(&p, run, m->of[h].to);
            put(&p, run, dx_halfedge_from(m, m->of[h].prev));
            put(&p, run, u);
            put(&p, run, v);
            flatten(&p);
            if ((dx_flat_in_sector(p.at[0], p.at[1], p.at[2]) || m->of[h].to == u ||
                 m->of[m->of[h].prev ^ 1].to == u) &&
                (dx_flat_in_sector(p.at[0], p.at[1], p.at[3]) || m->of[h].to == v ||
                 m->of[m->of[h].prev ^ 1].to == v))
                return h;
        }
        h = dx_halfedge_around(m, h);
    } while (h != first);
    return NONE;
}
