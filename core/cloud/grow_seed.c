/* The first triangle of a component. */
#include "core/cloud/grow_priv.h"

#include <math.h>

/* Angles at p and q, and lengths, as for any other triangle; *cos_r of the angle at r. */
static bool is_fit(const struct dx_grow_run *run, uint32_t p, uint32_t q, uint32_t r, double *cos_r)
{
    double pq[3], pr[3], qr[3], pq_len, pr_len, qr_len;

    dx_grow_between(pq, run, p, q);
    dx_grow_between(pr, run, p, r);
    dx_grow_between(qr, run, q, r);
    pq_len = sqrt(dx_grow_dot(pq, pq));
    pr_len = sqrt(dx_grow_dot(pr, pr));
    qr_len = sqrt(dx_grow_dot(qr, qr));
    *cos_r = dx_grow_dot(pr, qr) / (pr_len * qr_len);
    return (pr_len > qr_len ? pr_len : qr_len) < dx_grow_reach(run, p, q) &&
           dx_grow_dot(pq, pr) > run->cos_angle * pq_len * pr_len &&
           -dx_grow_dot(pq, qr) > run->cos_angle * pq_len * qr_len;
}

/* To the viewpoint, or up. */
static bool faces_away(const struct dx_grow_run *run, const uint32_t v[3])
{
    const struct dx_cloud *c = run->cloud;
    double n[3], towards[3] = {0, 0, 1};

    dx_grow_face_normal(n, run, v[0], v[1], v[2]);
    for (int k = 0; k < 3 && run->config->viewpoint; k++)
        towards[k] = (run->config->viewpoint[c->axis[k]] - c->origin[k]) / c->step - c->at[v[0]][k];
    return dx_grow_dot(n, towards) < 0;
}

bool dx_grow_seed(const struct dx_grow_run *run, uint32_t v[3], uint32_t p)
{
    const uint32_t *near = dx_neighbours_of(run->nb, p);
    const uint32_t k = run->nb->k < DX_GROW_K ? run->nb->k : DX_GROW_K;
    double least = 1;
    bool found = false;

    v[0] = p;
    v[1] = near[0];
    if (k == 0 || dx_grow_is_used(run, v[1]))
        return false;
    for (uint32_t i = 1; i < k; i++) {
        double cos_r, n[3];

        dx_grow_face_normal(n, run, v[0], v[1], near[i]);
        if (dx_grow_is_used(run, near[i]) || dx_grow_dot(n, n) == 0 ||
            !is_fit(run, v[0], v[1], near[i], &cos_r) || !(cos_r < least))
            continue;
        least = cos_r;
        v[2] = near[i];
        found = true;
    }
    if (!found)
        return false;
    if (faces_away(run, v)) {
        v[0] = v[1];
        v[1] = p;
    }
    return dx_grow_is_clear(run, v, true);
}
