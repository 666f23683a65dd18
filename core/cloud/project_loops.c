/*
 * Small holes that remain are closed, whatever the planes of their points say: the loop of boundary
 * edges around one is cut ear by ear, the roundest first. An ear must look to the side to which its
 * corners look in the mean, so that the outer rim of a small patch is not taken for a hole.
 */
#include "core/cloud/project_priv.h"

#include <math.h>

#define MAX_LOOP DX_PROJECT_MAX_LOOP

static void corner(double d[3], const struct dx_project_run *run, uint32_t from, uint32_t to)
{
    for (int k = 0; k < 3; k++)
        d[k] = run->cloud->at[to][k] - run->cloud->at[from][k];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* Direction d turned about v's normal: whether, going left from `from`, it comes before `to`. */
static bool comes_before(const struct dx_project_run *run, uint32_t v, uint32_t from, uint32_t d,
                         uint32_t to)
{
    double n[3], a[3], b[3], c[3], ab[3], bc[3], ac[3];
    bool d_left, to_left;

    for (int k = 0; k < 3; k++)
        n[k] = (double)run->point[v].normal[k];
    corner(a, run, v, from);
    corner(b, run, v, d);
    corner(c, run, v, to);
    cross(ab, a, b);
    cross(bc, b, c);
    cross(ac, a, c);
    d_left = dot(n, ab) > 0;
    to_left = dot(n, ac) > 0;
    if (d_left != to_left)
        return d_left;
    return dot(n, bc) > 0;
}

/* The hole is to the left of edge u-v; where its rim goes on from v. UINT32_MAX: u-v has none. */
static uint32_t next_on_rim(const struct dx_project_run *run, uint32_t u, uint32_t v)
{
    const uint32_t ring = run->point[v].ring, n = dx_ring_n(&run->rings, ring);
    const uint32_t *list = dx_ring_list(&run->rings, ring);
    uint32_t best = UINT32_MAX;
    bool found = false;

    for (uint32_t k = 0; k < n; k++) {
        const uint32_t last = list[k] & ~DX_RING_FIRST;

        found |= list[k] == (u | DX_RING_FIRST);
        if (k + 1 < n && !(list[k + 1] & DX_RING_FIRST))
            continue;
        /* of several chains, the one before u: the last to the left of u */
        if (best == UINT32_MAX || comes_before(run, v, u, best, last))
            best = last;
    }
    return found ? best : UINT32_MAX;
}

/* The rim that begins with edge a-b; how many points, 0: too many or no rim. */
static uint32_t trace(const struct dx_project_run *run, uint32_t *rim, uint32_t a, uint32_t b)
{
    uint32_t n = 0, u = a, v = b;

    do {
        uint32_t w;

        if (n == MAX_LOOP || n == run->config->max_loop)
            return 0;
        rim[n++] = v;
        w = next_on_rim(run, u, v);
        if (w == UINT32_MAX)
            return 0;
        u = v;
        v = w;
    } while (u != a || v != b);
    return n;
}

/* How round ear (a, b, c) is: area over squared sides; 0 where it may not be made. */
static double roundness(const struct dx_project_run *run, uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t v[3] = {a, b, c};
    double p[3], q[3], r[3], n[3], area, towards = 0;

    if (!dx_project_fits(run, a, b, c))
        return 0;
    corner(p, run, a, b);
    corner(q, run, a, c);
    corner(r, run, b, c);
    cross(n, p, q);
    area = sqrt(dot(n, n));
    for (int m = 0; m < 3; m++) {
        double of_point[3];

        for (int k = 0; k < 3; k++)
            of_point[k] = (double)run->point[v[m]].normal[k];
        towards += dot(n, of_point) / sqrt(dot(of_point, of_point));
    }
    if (!(towards > 0))
        return 0;
    return area / (dot(p, p) + dot(q, q) + dot(r, r));
}

static int cut_ears(struct dx_project_run *run, uint32_t *rim, uint32_t n)
{
    while (n >= 3) {
        double best = 0;
        uint32_t at = 0, before, after;
        int rc;

        for (uint32_t k = 0; k < n; k++) {
            const double round = roundness(run, rim[(k + n - 1) % n], rim[k], rim[(k + 1) % n]);

            if (round > best) {
                best = round;
                at = k;
            }
        }
        if (best == 0)
            return 0;
        before = rim[(at + n - 1) % n];
        after = rim[(at + 1) % n];
        rc = dx_project_add(run, before, rim[at], after);
        if (rc < 0)
            return rc;
        run->stats->n_loop_triangles++;
        for (n--; at < n; at++)
            rim[at] = rim[at + 1];
        if (n == 3 && !dx_project_fits(run, rim[0], rim[1], rim[2]))
            return 0;
    }
    return 0;
}

/* Holes to the left of the last edges of v's chains. */
static int close_at(struct dx_project_run *run, uint32_t v)
{
    uint32_t last[DX_RING_MAX], n_last = 0;
    const uint32_t n = dx_ring_n(&run->rings, run->point[v].ring);
    const uint32_t *list = dx_ring_list(&run->rings, run->point[v].ring);
    int rc = 0;

    for (uint32_t k = 0; k < n; k++)
        if (k + 1 == n || (list[k + 1] & DX_RING_FIRST))
            last[n_last++] = list[k] & ~DX_RING_FIRST;
    for (uint32_t k = 0; k < n_last && rc == 0; k++) {
        uint32_t rim[MAX_LOOP], n_rim = trace(run, rim, v, last[k]);

        rc = cut_ears(run, rim, n_rim);
    }
    return rc;
}

int dx_project_close_loops(struct dx_project_run *run)
{
    int rc = 0;

    for (uint32_t k = 0; k < run->cloud->n && rc == 0; k++)
        if (run->state[k] == DX_BOUNDARY)
            rc = close_at(run, k);
    return rc;
}
