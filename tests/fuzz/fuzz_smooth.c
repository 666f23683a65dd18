/*
 * Small clouds through all stages of reconstruction from noise: no input may crash them, and the
 * half-edges must be sound after each stage (tests/unit/halfedge_check.h).
 */
#include "core/cloud/smooth_stages.h"
#include "tests/unit/halfedge_check.h"

#include <math.h>

#define MAX_POINTS 128

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

static void expect_sound(const struct dx_stages *s)
{
    if (halfedge_check(&s->mesh.edges) || halfedge_count(&s->mesh.edges).n_corners)
        abort();
    for (uint32_t v = 0; v < s->mesh.edges.n_vertices; v++)
        for (int k = 0; k < 3; k++)
            if (!isfinite(s->mesh.at[v][k]))
                abort();
}

/* What comes before the points: one bit or a few for each choice. */
static void run(struct dx_stages *s, const uint8_t head[4])
{
    const struct dx_cloud_smooth_config smooth = {.quadric = head[0] & 1};
    struct dx_cloud_smooth_scale scale;
    struct dx_cloud_smooth_stats stats;
    struct dx_cluster_config cluster;
    struct dx_refine_config refine;
    struct dx_refine_stats refined;
    struct dx_grow_config grow;
    struct dx_grow_stats grown;
    int rc = 0;

    dx_cluster_defaults(&cluster);
    dx_grow_defaults(&grow);
    dx_refine_defaults(&refine);
    cluster.min_points = 1 + head[1] % 8;
    cluster.max_points = head[0] & 2 ? 0 : cluster.min_points;
    cluster.split = head[0] & 4 ? DX_CLUSTER_FLAT : DX_CLUSTER_ACROSS;
    grow.max_ratio = 1.5 + head[2] % 16;
    grow.max_loop = head[0] & 8 ? 0 : head[3] % (DX_GROW_MAX_LOOP + 1);
    refine.tolerance = head[0] & 16 ? 0 : 0.1;
    if (head[0] & 32)
        rc = dx_stages_smooth(s, &scale, &stats, &smooth, NULL);
    if (rc == 0 && head[0] & 64)
        rc = dx_stages_cluster(s, &cluster, NULL) || dx_stages_reduce(s, NULL);
    if (rc == 0)
        rc = dx_stages_grow(s, &grown, &grow, NULL);
    if (rc)
        abort();
    expect_sound(s);
    for (int pass = 0; pass < 2; pass++) {
        if (dx_stages_refine(s, &refined, &refine, NULL) < 0)
            abort();
        expect_sound(s);
    }
    if (dx_stages_orient(s, NULL, NULL) < 0)
        abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    static double xyz[3 * MAX_POINTS];
    struct dx_stages s;
    size_t n;

    if (len < 4)
        return 0;
    n = (len - 4) / 3;
    n = n < MAX_POINTS ? n : MAX_POINTS;
    for (size_t k = 0; k < 3 * n; k++)
        xyz[k] = bytes[4 + k] == 255 ? NAN : bytes[4 + k];
    if (dx_stages_init(&s, xyz, n, NULL, NULL) < 0)
        return 0;
    run(&s, bytes);
    dx_stages_fini(&s);
    return 0;
}
