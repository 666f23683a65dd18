/*
 * Candidates of a point (section 5.3): those near it whose normals look to its side and whose
 * height over its tangent plane is not beyond what curvature and noise explain, turned into the
 * plane and ordered by angle. Curvature is that of the nearest neighbours, before any is left out.
 */
#include "core/cloud/delaunay_priv.h"

#include <math.h>
#include <string.h>

#define LEAST_DELTA    0.1 /* the paper's delta: curvature times spacing */
#define MOST_DELTA     1.0
#define LEAST_RATIO    1e-3 /* of curvatures: planes and saddles have none */
#define STEEP          0.5  /* height over radius, at most */
#define NOISE          4.0  /* heights of most, that are no reason to leave out a point */
#define PAPER_AT_LEAST 8    /* candidates */

static double distance(const int32_t a[3], const int32_t b[3])
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};

    return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

/* A point that may be a candidate. */
static void put(struct dx_star_site *site, const struct dx_delaunay_run *run, uint32_t rank)
{
    const struct dx_tangent *t = &site->plane;
    const float *m = run->normals[rank];
    const uint32_t n = site->n_found;
    const double side = (double)m[0] * t->n[0] + (double)m[1] * t->n[1] + (double)m[2] * t->n[2];

    site->found[n] = rank;
    site->n_found +=
        dx_tangent_put(&site->found_at[n], &site->found_height[n], t, run->cloud->at[rank]) &&
        side > 0;
}

/* What is found, by angle. */
static void order(struct dx_star_site *site)
{
    dx_angle_order(site->order, site->found_at, site->found, site->n_found);
    site->n = site->n_found;
    for (uint32_t k = 0; k < site->n; k++) {
        site->rank[k] = site->found[site->order[k]];
        site->at[k] = site->found_at[site->order[k]];
    }
}

static void prune_heights(struct dx_star_site *site)
{
    uint32_t n = 0;

    for (uint32_t k = 0; k < site->n; k++)
        if (site->found_height[site->order[k]] <= site->height) {
            site->order[n] = site->order[k];
            site->rank[n] = site->rank[k];
            site->at[n++] = site->at[k];
        }
    site->n = n;
}

static void prune_edges(struct dx_star_site *site, const struct dx_delaunay_run *run)
{
    uint32_t n = 0;

    for (uint32_t k = 0; k < site->n; k++)
        if (distance(run->cloud->at[site->rank[k]], site->plane.at) <= run->max_edge) {
            site->rank[n] = site->rank[k];
            site->at[n++] = site->at[k];
        }
    site->n = n;
}

/* m_p distances of the nearest point, but at least as many points as a star needs. */
static double paper_radius(const struct dx_star_site *site, const struct dx_delaunay_run *run,
                           double least, double most)
{
    const uint32_t *near = dx_neighbours_of(run->nb, site->plane.rank);
    const uint32_t k = run->k < PAPER_AT_LEAST ? run->k : PAPER_AT_LEAST;
    const double enough = distance(run->cloud->at[near[k - 1]], site->plane.at);
    double m = least > LEAST_RATIO * most ? 2 * most / least : 2 / LEAST_RATIO;

    m = m < run->config->least_m ? run->config->least_m : m;
    m = m > run->config->most_m ? run->config->most_m : m;
    return m * site->nearest > enough ? m * site->nearest : enough;
}

/* How high the surface may be at twice the sampling distance (theorem 1b). */
static double surface_height(double least, double most, double spacing)
{
    double delta = most * spacing;

    delta = delta < LEAST_DELTA ? LEAST_DELTA : delta > MOST_DELTA ? MOST_DELTA : delta;
    return least > 0 ? (sqrt(1 + 4 * delta * delta) - 1) / least : INFINITY;
}

/* What is a matter of curvature: only where a height is not that of most others. */
static void prune(struct dx_star_site *site, const struct dx_delaunay_run *run)
{
    double sum = 0, highest = 0, of_most, least, most;

    for (uint32_t k = 0; k < site->n_found; k++) {
        const double h = site->found_height[k];

        sum += h * h;
        highest = h > highest ? h : highest;
    }
    of_most = NOISE * sqrt(sum / site->n_found);
    site->height = INFINITY;
    if (highest <= of_most && !run->config->paper_radius)
        return;
    dx_star_curvature(&least, &most, site, run);
    site->height = surface_height(least, most, site->nearest);
    site->height = site->height < STEEP * site->reach ? site->height : STEEP * site->reach;
    site->height = site->height > of_most ? site->height : of_most;
    if (run->config->paper_radius)
        site->paper_radius = paper_radius(site, run, least, most);
    prune_heights(site);
}

bool dx_star_gather(struct dx_star_site *site, const struct dx_delaunay_run *run, uint32_t rank)
{
    const uint32_t *near = dx_neighbours_of(run->nb, rank);

    site->n = site->n_found = 0;
    if (!dx_tangent_of(&site->plane, run, rank))
        return false;
    site->reach = DX_STAR_FLAT / site->plane.scale;
    site->nearest = distance(run->cloud->at[near[0]], site->plane.at);
    for (uint32_t k = 0; k < run->k; k++)
        put(site, run, near[k]);
    if (site->n_found == 0)
        return true;
    order(site);
    prune(site, run);
    if (run->max_edge < INFINITY)
        prune_edges(site, run);
    return true;
}

void dx_star_widen(struct dx_star_site *site, const struct dx_delaunay_run *run, double radius)
{
    const double steep = STEEP / site->reach;
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
    site->n_found = 0;
    for (uint32_t k = 0; k < n; k++)
        if (site->near[k].rank != site->plane.rank)
            put(site, run, site->near[k].rank);
    order(site);
    (void)steep;
    site->reach = radius;
    if (site->height < INFINITY)
        prune_heights(site);
    if (run->max_edge < INFINITY)
        prune_edges(site, run);
}
