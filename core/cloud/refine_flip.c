/* Diagonals that are longer than the other one of their two triangles are flipped, where that folds
 * nothing. Each flip makes the edges shorter in sum, so that there is an end. */
#include "core/cloud/refine_priv.h"

#include "core/base/trig.h"

#define SHORTER 0.9999 /* squared: what rounding could make shorter is not */

struct quad {
    const double *u, *v, *a, *b; /* the edge, and what is across: (u, v, a) and (v, u, b) */
};

/* The new triangles (a, u, b) and (b, v, a) look where the old ones do. Both being to the left in
 * the plane of the mean normal is that the quad is strictly convex there. */
static bool keeps_side(const struct quad *q, double cos_turn)
{
    double n1[3], n2[3], m1[3], m2[3], mean[3];

    dx_refine_normal(n1, q->u, q->v, q->a);
    dx_refine_normal(n2, q->v, q->u, q->b);
    dx_refine_normal(m1, q->a, q->u, q->b);
    dx_refine_normal(m2, q->b, q->v, q->a);
    for (int k = 0; k < 3; k++)
        mean[k] = n1[k] + n2[k];
    if (!(dx_refine_dot(mean, m1) > 0 && dx_refine_dot(mean, m2) > 0))
        return false;
    return dx_refine_dot(n1, m1) >= cos_turn && dx_refine_dot(n1, m2) >= cos_turn &&
           dx_refine_dot(n2, m1) >= cos_turn && dx_refine_dot(n2, m2) >= cos_turn;
}

static bool is_worth_it(const struct dx_surface_mesh *mesh, uint32_t h, double cos_turn)
{
    const struct dx_halfedges *m = &mesh->edges;
    struct quad q;

    if (dx_halfedge_is_border(m, h) || dx_halfedge_is_border(m, h ^ 1))
        return false;
    q = (struct quad){mesh->at[dx_halfedge_from(m, h)], mesh->at[m->of[h].to],
                      mesh->at[dx_halfedge_apex(m, h)], mesh->at[dx_halfedge_apex(m, h ^ 1)]};
    return dx_refine_len2(q.a, q.b) < SHORTER * dx_refine_len2(q.u, q.v) &&
           keeps_side(&q, cos_turn) && dx_halfedge_may_flip(m, h);
}

void dx_refine_flip(struct dx_surface_mesh *mesh, struct dx_refine_stats *stats,
                    const struct dx_refine_config *config)
{
    const double cos_turn = dx_cos(dx_rad(config->max_turn_deg));
    uint32_t n = 1;

    for (; n > 0 && stats->n_sweeps < config->max_sweeps; stats->n_sweeps++) {
        n = 0;
        for (uint32_t h = 0; h < mesh->edges.n; h += 2) {
            if (!is_worth_it(mesh, h, cos_turn))
                continue;
            dx_halfedges_flip(&mesh->edges, h);
            n++;
        }
        stats->n_flips += n;
    }
}
