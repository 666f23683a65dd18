/*
 * Candidates of a point (section 5.3): those near it whose normals look to its side and whose height
 * over its tangent plane is not beyond what its curvature explains, turned into the plane and
 * ordered by angle. Curvature is that of the nearest neighbours, before any is left out.
 */
#include "core/cloud/delaunay_priv.h"

#include <math.h>

#define LEAST_DELTA    0.1 /* the paper's delta: curvature times spacing */
#define MOST_DELTA     1.0
#define LEAST_RATIO    1e-3 /* of curvatures: planes and saddles have none */
#define STEEP          0.5  /* height over radius, at most */
#define NOISE          4.0  /* heights of most, that are no reason to leave out a point */
#define PAPER_AT_LEAST 8    /* candidates */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Puts point q into the plane; false: it is no candidate of this one. */
static bool put(struct dx_star_site *site, const struct dx_delaunay_run *run, uint32_t rank)
{
    const struct dx_tangent *t = &site->plane;
    const int32_t *q = run->cloud->at[rank];
    const float *m = run->normals[rank];
    const double d[3] = {q[0] - t->at[0], q[1] - t->at[1], q[2] - t->at[2]};
    const double normal[3] = {(double)m[0], (double)m[1], (double)m[2]};
    struct dx_candidate *c = &site->candidate[site->n];

    if (!(dot(normal, t->n) > 0) || !dx_tangent_flat(&c->at, t, q))
        return false;
    c->rank = rank;
    c->d2 = dot(d, d);
    c->height = fabs(dot(d, t->n));
    c->curvature = (dot(d, t->n) - dot(d, normal)) / c->d2;
    site->order[site->n] = (struct dx_angle){dx_angle_key(c->at), c->at, site->n};
    site->n++;
    return true;
}

/* Keeps the order of those that remain, which are known by rank from now on; of several in one place
 * the lowest. */
static void prune(struct dx_star_site *site, double height, double radius)
{
    uint32_t n = 0;

    for (uint32_t k = 0; k < site->n; k++) {
        const struct dx_candidate *c = &site->candidate[site->order[k].number];
        const struct dx_angle *last = &site->order[n - (n > 0)];

        if (c->height > height || c->d2 > radius * radius)
            continue;
        if (n > 0 && last->at.x == c->at.x && last->at.y == c->at.y) {
            site->order[n - 1].number = c->rank < last->number ? c->rank : last->number;
            continue;
        }
        site->order[n] = site->order[k];
        site->order[n++].number = c->rank;
    }
    site->n = n;
}

/* m_p distances of the nearest point, but at least as many points as a star needs. */
static double paper_radius(const struct dx_star_site *site, const struct dx_delaunay_run *run,
                           double least, double most)
{
    const uint32_t *near = dx_neighbours_of(run->nb, site->plane.rank);
    const uint32_t k = run->nb->k < PAPER_AT_LEAST ? run->nb->k : PAPER_AT_LEAST;
    const int32_t *q = run->cloud->at[near[k - 1]], *p = site->plane.at;
    const double d[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
    double m = least > LEAST_RATIO * most ? 2 * most / least : 2 / LEAST_RATIO, radius;

    m = m < run->config->least_m ? run->config->least_m : m;
    m = m > run->config->most_m ? run->config->most_m : m;
    radius = m * site->nearest;
    return radius * radius > dot(d, d) ? radius : sqrt(dot(d, d));
}

/* How high the surface may be at twice the sampling distance (theorem 1b). */
static double height_of(double least, double most, double spacing)
{
    double delta = most * spacing;

    delta = delta < LEAST_DELTA ? LEAST_DELTA : delta > MOST_DELTA ? MOST_DELTA : delta;
    return least > 0 ? (sqrt(1 + 4 * delta * delta) - 1) / least : INFINITY;
}

/* Root mean square of the heights of candidates: what noise, and planes that are not tangent, make
 * of them. */
static double height_of_most(const struct dx_star_site *site)
{
    double sum = 0;

    for (uint32_t k = 0; k < site->n; k++)
        sum += site->candidate[k].height * site->candidate[k].height;
    return sqrt(sum / site->n);
}

static double bound_height(const struct dx_star_site *site)
{
    const double steep = STEEP * site->reach, height = site->height < steep ? site->height : steep;

    return height > NOISE * site->height_of_most ? height : NOISE * site->height_of_most;
}

bool dx_star_gather(struct dx_star_site *site, const struct dx_delaunay_run *run, uint32_t rank)
{
    const uint32_t *near = dx_neighbours_of(run->nb, rank);
    double least, most;

    site->n = 0;
    if (!dx_tangent_of(&site->plane, run, rank))
        return false;
    site->reach = DX_STAR_FLAT / site->plane.scale;
    for (uint32_t k = 0; k < run->nb->k; k++)
        put(site, run, near[k]);
    if (site->n == 0)
        return true;
    site->nearest = sqrt(site->candidate[0].d2);
    dx_angle_sort(site->order, site->n);
    dx_star_curvature(&least, &most, site, run->quarter_turns);
    site->height = height_of(least, most, site->nearest);
    site->height_of_most = height_of_most(site);
    site->paper_radius = paper_radius(site, run, least, most);
    prune(site, bound_height(site), run->max_edge);
    return true;
}

void dx_star_widen(struct dx_star_site *site, const struct dx_delaunay_run *run, double radius)
{
    uint32_t n;

    radius = radius < DX_CLOUD_LATTICE * 2.0 ? radius : DX_CLOUD_LATTICE * 2.0;
    for (;;) {
        n = dx_cloud_within(run->cloud, site->plane.at, (int32_t)radius, site->near,
                            DX_STAR_MAX_NEAR);
        if (n <= DX_STAR_MAX_NEAR || radius < 2)
            break;
        radius *= 0.8;
    }
    n = n < DX_STAR_MAX_NEAR ? n : DX_STAR_MAX_NEAR;
    site->n = 0;
    site->reach = radius;
    for (uint32_t k = 0; k < n; k++)
        if (site->near[k].rank != site->plane.rank)
            put(site, run, site->near[k].rank);
    dx_angle_sort(site->order, site->n);
    prune(site, bound_height(site), run->max_edge);
}
