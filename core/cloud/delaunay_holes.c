/*
 * Small holes that are left are filled (section 6), where the number of their edges and their area
 * say that they are none of the surface: the rim, projected along the mean normal of its points, is
 * cut into the triangles that bend least against each other and against those around the hole.
 */
#include "core/cloud/delaunay_priv.h"

#include <math.h>

#define MAX_LOOP DX_DELAUNAY_MAX_LOOP
#define LARGE    4 /* areas of the triangles around, for each edge of the rim: at most */

/* A rim and the best cuts of its parts, from corner i to corner j. */
struct hole {
    const struct dx_delaunay_run *run;
    uint32_t n;
    uint32_t rank[MAX_LOOP];
    double at[MAX_LOOP][3], flat[MAX_LOOP][2];
    double beyond[MAX_LOOP][3]; /* normal of the triangle across edge i, i + 1 */
    double area_around;
    bool chord[MAX_LOOP][MAX_LOOP]; /* i-j may be an edge */
    double bend[MAX_LOOP][MAX_LOOP], area[MAX_LOOP][MAX_LOOP];
    uint32_t apex[MAX_LOOP][MAX_LOOP]; /* of the triangle at i-j; n: none */
};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Of triangle a, b, c; its length is twice the area. */
static void normal_of(double out[3], const double a[3], const double b[3], const double c[3])
{
    double p[3], q[3];

    for (int k = 0; k < 3; k++) {
        p[k] = b[k] - a[k];
        q[k] = c[k] - a[k];
    }
    for (int k = 0; k < 3; k++)
        out[k] = p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3];
}

/* 0: side by side, 2: folded. */
static double bend_of(const double a[3], const double b[3])
{
    const double len = sqrt(dot(a, a) * dot(b, b));

    return len > 0 ? 1 - dot(a, b) / len : 2;
}

static double turn(const struct hole *h, uint32_t a, uint32_t b, uint32_t c)
{
    const double *p = h->flat[a], *q = h->flat[b], *r = h->flat[c];

    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
}

/* Edges a-b and c-d cross, or one ends on the other. */
static bool touch(const struct hole *h, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    if (a == c || a == d || b == c || b == d)
        return false;
    return turn(h, a, b, c) * turn(h, a, b, d) <= 0 && turn(h, c, d, a) * turn(h, c, d, b) <= 0;
}

/* The third corner of the triangle across rim edge i: the one before it in the ring of its end. */
static uint32_t across(const struct dx_delaunay_run *run, uint32_t from, uint32_t to)
{
    const uint32_t n = dx_ring_n(&run->rings, run->ring[from]);
    const uint32_t *list = dx_ring_list(&run->rings, run->ring[from]);

    for (uint32_t k = 1; k < n; k++)
        if (list[k] == to)
            return list[k - 1] & ~DX_RING_FIRST;
    return to;
}

static bool is_edge(const struct dx_delaunay_run *run, uint32_t a, uint32_t b)
{
    const uint32_t n = dx_ring_n(&run->rings, run->ring[a]);
    const uint32_t *list = dx_ring_list(&run->rings, run->ring[a]);

    for (uint32_t k = 0; k < n; k++)
        if ((list[k] & ~DX_RING_FIRST) == b)
            return true;
    return false;
}

static void set_corners(struct hole *h, double mean[3])
{
    const struct dx_delaunay_run *run = h->run;

    mean[0] = mean[1] = mean[2] = h->area_around = 0;
    for (uint32_t i = 0; i < h->n; i++) {
        const uint32_t v = h->rank[i], next = h->rank[(i + 1) % h->n];
        const int32_t *p = run->cloud->at[h->rank[0]];
        double there[3], after[3];

        for (int k = 0; k < 3; k++) {
            h->at[i][k] = run->cloud->at[v][k] - p[k];
            after[k] = run->cloud->at[next][k] - p[k];
            there[k] = run->cloud->at[across(run, v, next)][k] - p[k];
            mean[k] += (double)run->normals[v][k];
        }
        normal_of(h->beyond[i], after, h->at[i], there);
        h->area_around += sqrt(dot(h->beyond[i], h->beyond[i])) / 2 / h->n;
    }
}

/* The rim in the plane across the mean normal; false: no plane, or not simple, or too large. */
static bool project(struct hole *h)
{
    double n[3], u[3] = {0}, v[3], len, area = 0;
    int least = 0;

    set_corners(h, n);
    len = sqrt(dot(n, n));
    if (!(len > 0))
        return false;
    for (int k = 0; k < 3; k++) {
        n[k] /= len;
        least = fabs(n[k]) < fabs(n[least]) ? k : least;
    }
    u[(least + 1) % 3] = n[(least + 2) % 3];
    u[(least + 2) % 3] = -n[(least + 1) % 3];
    len = sqrt(dot(u, u));
    for (int k = 0; k < 3; k++)
        v[k] = (n[(k + 1) % 3] * u[(k + 2) % 3] - n[(k + 2) % 3] * u[(k + 1) % 3]) / len;
    for (uint32_t i = 0; i < h->n; i++) {
        h->flat[i][0] = dot(h->at[i], u) / len;
        h->flat[i][1] = dot(h->at[i], v);
    }
    for (uint32_t i = 1; i + 1 < h->n; i++)
        area += turn(h, 0, i, i + 1) / 2;
    if (!(area > 0) || area > LARGE * h->area_around * h->n)
        return false;
    for (uint32_t i = 0; i < h->n; i++)
        for (uint32_t j = i + 1; j < h->n; j++)
            if (touch(h, i, (i + 1) % h->n, j, (j + 1) % h->n))
                return false;
    return true;
}

/* Chords that cross no edge of the rim and are not in the mesh; whether they are inside, triangles
 * tell, which must turn left. */
static void set_chords(struct hole *h)
{
    for (uint32_t i = 0; i < h->n; i++)
        for (uint32_t j = i + 1; j < h->n; j++) {
            const bool side = j == i + 1 || (i == 0 && j == h->n - 1);

            h->chord[i][j] =
                side || (h->rank[i] != h->rank[j] && !is_edge(h->run, h->rank[i], h->rank[j]));
            for (uint32_t k = 0; k < h->n && !side && h->chord[i][j]; k++)
                h->chord[i][j] = !touch(h, i, j, k, (k + 1) % h->n);
        }
}

/* The normal across i-j, seen from a triangle at its left: of the mesh, or of the part that is cut
 * off. */
static const double *normal_across(const struct hole *h, uint32_t i, uint32_t j, double held[3])
{
    if (j == i + 1)
        return h->beyond[i];
    normal_of(held, h->at[i], h->at[h->apex[i][j]], h->at[j]);
    return held;
}

/* The best triangle at i-j, over all corners between. */
static void cut(struct hole *h, uint32_t i, uint32_t j)
{
    h->bend[i][j] = h->area[i][j] = INFINITY;
    h->apex[i][j] = h->n;
    for (uint32_t k = i + 1; k < j && h->chord[i][j]; k++) {
        double own[3], held[3], bend, area, x;

        if (h->bend[i][k] == INFINITY || h->bend[k][j] == INFINITY || !(turn(h, i, k, j) > 0))
            continue;
        normal_of(own, h->at[i], h->at[k], h->at[j]);
        bend = h->bend[i][k] > h->bend[k][j] ? h->bend[i][k] : h->bend[k][j];
        x = bend_of(own, normal_across(h, i, k, held));
        bend = x > bend ? x : bend;
        x = bend_of(own, normal_across(h, k, j, held));
        bend = x > bend ? x : bend;
        if (i == 0 && j == h->n - 1) { /* the last: i-j is of the rim */
            x = bend_of(own, h->beyond[j]);
            bend = x > bend ? x : bend;
        }
        area = h->area[i][k] + h->area[k][j] + sqrt(dot(own, own));
        if (bend < h->bend[i][j] || (bend == h->bend[i][j] && area < h->area[i][j])) {
            h->bend[i][j] = bend;
            h->area[i][j] = area;
            h->apex[i][j] = k;
        }
    }
}

/* Triangles of the part from i to j. */
static int add_part(const struct hole *h, struct dx_delaunay_run *run, uint32_t i, uint32_t j)
{
    const uint32_t k = j > i + 1 ? h->apex[i][j] : 0;
    int rc;

    if (j <= i + 1)
        return 0;
    rc = add_part(h, run, i, k);
    if (rc == 0)
        rc = add_part(h, run, k, j);
    if (rc < 0 || !dx_delaunay_fits(run, h->rank[i], h->rank[k], h->rank[j]))
        return rc;
    run->stats->n_loop_triangles++;
    return dx_delaunay_add(run, h->rank[i], h->rank[k], h->rank[j]);
}

static int fill(struct dx_delaunay_run *run, struct hole *h)
{
    if (h->n < 3 || !project(h))
        return 0;
    set_chords(h);
    for (uint32_t i = 0; i + 1 < h->n; i++) {
        h->bend[i][i + 1] = h->area[i][i + 1] = 0;
        h->apex[i][i + 1] = h->n;
    }
    for (uint32_t len = 2; len < h->n; len++)
        for (uint32_t i = 0; i + len < h->n; i++)
            cut(h, i, i + len);
    if (h->bend[0][h->n - 1] == INFINITY)
        return 0;
    return add_part(h, run, 0, h->n - 1);
}

/* Holes to the left of the last edges of v's chains. */
static int fill_at(struct dx_delaunay_run *run, struct hole *h, uint32_t v)
{
    uint32_t last[DX_RING_MAX], n_last = 0;
    const uint32_t n = dx_ring_n(&run->rings, run->ring[v]);
    const uint32_t *list = dx_ring_list(&run->rings, run->ring[v]);
    int rc = 0;

    for (uint32_t k = 0; k < n; k++)
        if (k + 1 == n || (list[k + 1] & DX_RING_FIRST))
            last[n_last++] = list[k] & ~DX_RING_FIRST;
    for (uint32_t k = 0; k < n_last && rc == 0; k++) {
        if (run->ring[v] == DX_RING_WHOLE)
            break;
        h->n = dx_delaunay_trace(h->rank, run, v, last[k]);
        rc = fill(run, h);
    }
    return rc;
}

int dx_delaunay_fill(struct dx_delaunay_run *run)
{
    struct hole hole = {.run = run};
    int rc = 0;

    for (uint32_t v = 0; v < run->cloud->n && rc == 0; v++)
        if (run->ring[v] != DX_RING_WHOLE)
            rc = fill_at(run, &hole, v);
    return rc;
}
