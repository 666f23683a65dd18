/* Small holes that remain are cut into ears, the roundest first. An ear must look to the side to
 * which its corners look in the mean, so that the rim of a small patch is not taken for a hole. */
#include "core/cloud/grow_priv.h"

#include <errno.h>
#include <math.h>

/* How many edges the border of b has; 0: more than are closed. */
static uint32_t loop_len(const struct dx_grow_run *run, uint32_t b)
{
    uint32_t n = 0, h = b;

    do {
        if (n++ == run->config->max_loop)
            return 0;
        h = run->mesh->of[h].next;
    } while (h != b);
    return n;
}

/* Of the ear of border half-edge b and the next: area over squared sides; 0: not to be made. */
static double roundness(const struct dx_grow_run *run, uint32_t b)
{
    const struct dx_halfedges *m = run->mesh;
    const uint32_t u = dx_halfedge_from(m, b), v = m->of[b].to, q = m->of[m->of[b].next].to;
    double uv[3], uq[3], vq[3], n[3], mean[3];

    if (!dx_halfedge_fits(m, b, q, DX_NO_HALFEDGE))
        return 0;
    dx_grow_between(uv, run, u, v);
    dx_grow_between(uq, run, u, q);
    dx_grow_between(vq, run, v, q);
    dx_grow_cross(n, uv, uq);
    for (int k = 0; k < 3; k++)
        mean[k] = run->normal[u][k] + run->normal[v][k] + run->normal[q][k];
    /* three edges are a hole whatever the sides: they bound no patch but a triangle's own back,
     * which does not fit */
    if (!(dx_grow_dot(n, mean) > 0) && m->of[m->of[b].next].next != m->of[b].prev)
        return 0;
    return sqrt(dx_grow_dot(n, n)) /
           (dx_grow_dot(uv, uv) + dx_grow_dot(uq, uq) + dx_grow_dot(vq, vq));
}

/* The loop of b, while there is an ear. */
static int close_loop(struct dx_grow_run *run, uint32_t b)
{
    while (dx_halfedge_is_border(run->mesh, b)) {
        const struct dx_halfedges *m = run->mesh;
        double most = 0;
        uint32_t best = b, h = b;

        do {
            const double r = roundness(run, h);

            if (r > most) {
                most = r;
                best = h;
            }
            h = m->of[h].next;
        } while (h != b);
        if (!(most > 0))
            return 0;
        h = m->of[best].prev;
        if (dx_grow_add(run, best, m->of[m->of[best].next].to, DX_NO_HALFEDGE) < 0)
            return -ENOMEM;
        run->stats->n_loop_triangles++;
        b = h; /* goes on with what is left of the border */
    }
    return 0;
}

int dx_grow_close_loops(struct dx_grow_run *run)
{
    const uint32_t n = run->mesh->n;

    for (uint32_t h = 0; h < n; h++)
        if (dx_halfedge_is_border(run->mesh, h) && loop_len(run, h) && close_loop(run, h) < 0)
            return -ENOMEM;
    run->tail = 0;
    return 0;
}
