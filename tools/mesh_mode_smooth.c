/* dexel mesh --mode smooth: the stages of core/cloud/smooth_stages.h, their parameters as options.
 */
#include "core/cloud/smooth_stages.h"
#include "tools/mesh_mode.h"
#include "tools/mesh_smooth.h"

#include <errno.h>
#include <string.h>

static const char help[] =
    "  --stages LIST       which, in this order: smooth,cluster,reduce,grow,refine (all);\n"
    "                      without grow points are written, with normals\n"
    "  --passes N          of smoothing, 0 to 16 (1)\n"
    "  --fit plane|quadric what points are put on: quadric is better where the surface is curved,\n"
    "                      and takes twice as long (plane)\n"
    "  --sw N              width of the neighbourhood, spacings: 0.5 to 4 (from noise and "
    "curvature)\n"
    "  --sr N              height from which on points do not count, spacings: 0.1 to 10 (from "
    "noise)\n"
    "  --split v3|v1       clusters are cut across their longest axis, or as the paper has it "
    "(v3)\n"
    "  --variation S       share of the least extent from which on clusters are cut: 1e-9 to 1 "
    "(0.01)\n"
    "  --min-points N      of clusters that are cut for that, 1 to 1e6 (8)\n"
    "  --max-points N      of a cluster, 0: any (32)\n"
    "  --bend DEG          of the mesh at an edge, at most: 20 to 180 (100)\n"
    "  --angle DEG         no wider angle at the ends of an edge: 61 to 180 (140)\n"
    "  --ratio N           longest edge by the distance of the nearest point: 1.01 to 100 (3)\n"
    "  --loops N           close holes of at most N edges, 0 to 64 (16)\n"
    "  --refine N          passes of refining, 0 to 8 (2)\n"
    "  --tolerance N       edges so near to the points are not refined, spacings (0.1)\n";

static const char *const fits[] = {"plane", "quadric", NULL};
static const char *const splits[] = {[DX_CLUSTER_ACROSS] = "v3", [DX_CLUSTER_FLAT] = "v1", NULL};

#define AT(member) offsetof(struct dx_smooth_job_config, member)

static const struct dx_mesh_option options[] = {
    {"stages", DX_MESH_TEXT, AT(stages), 0, 0, NULL, NULL},
    {"passes", DX_MESH_COUNT, AT(n_passes), 0, 16, "passes", NULL},
    {"fit", DX_MESH_CHOICE, AT(fit), 0, 0, NULL, fits},
    {"sw", DX_MESH_NUMBER, AT(sw), 0.5, 4, "spacings", NULL},
    {"sr", DX_MESH_NUMBER, AT(sr), 0.1, 10, "spacings", NULL},
    {"split", DX_MESH_CHOICE, AT(split), 0, 0, NULL, splits},
    {"variation", DX_MESH_NUMBER, AT(max_variation), 1e-9, 1, "a share", NULL},
    {"min-points", DX_MESH_COUNT, AT(min_points), 1, 1000000, "points", NULL},
    {"max-points", DX_MESH_COUNT, AT(max_points), 0, 1000000, "points", NULL},
    {"bend", DX_MESH_NUMBER, AT(max_bend_deg), 20, 180, "degrees", NULL},
    {"angle", DX_MESH_NUMBER, AT(max_angle_deg), 61, 180, "degrees", NULL},
    {"ratio", DX_MESH_NUMBER, AT(max_ratio), 1.01, 100, "distances", NULL},
    {"loops", DX_MESH_COUNT, AT(max_loop), 0, DX_GROW_MAX_LOOP, "edges", NULL},
    {"refine", DX_MESH_COUNT, AT(n_refine), 0, 8, "passes", NULL},
    {"tolerance", DX_MESH_NUMBER, AT(tolerance), 0, 1000, "spacings", NULL},
    {0},
};

static void defaults(void *config)
{
    struct dx_cluster_config cluster;
    struct dx_refine_config refine;
    struct dx_grow_config grow;

    dx_cluster_defaults(&cluster);
    dx_grow_defaults(&grow);
    dx_refine_defaults(&refine);
    *(struct dx_smooth_job_config *)config = (struct dx_smooth_job_config){
        .n_passes = 1,
        .split = (int)cluster.split,
        .max_variation = cluster.max_variation,
        .min_points = cluster.min_points,
        .max_points = cluster.max_points,
        .max_bend_deg = grow.max_bend_deg,
        .max_angle_deg = grow.max_angle_deg,
        .max_ratio = grow.max_ratio,
        .max_loop = grow.max_loop,
        .n_refine = 2,
        .tolerance = refine.tolerance,
    };
}

/* Which of the names a list has, as bits; negative: it has another, or not in their order. */
static int parse_stages(const char *list)
{
    int bits = 0;

    for (size_t len; *list; list += len + (list[len] == ',')) {
        int k = 0;

        len = strcspn(list, ",");
        while (k < DX_N_SMOOTH_STAGES &&
               (strlen(dx_smooth_stages[k]) != len || strncmp(dx_smooth_stages[k], list, len) != 0))
            k++;
        if (k == DX_N_SMOOTH_STAGES || bits >> k) /* stages run in their order only */
            return -EINVAL;
        bits |= 1 << k;
    }
    return bits;
}

/* Stages that another one needs. */
static int check_stages(int bits, const char *list, struct dx_err *err)
{
    if (bits <= 0)
        return dx_err_set(err, -EINVAL,
                          "--stages: found '%s', expected some of smooth,cluster,reduce,grow,"
                          "refine in this order",
                          list);
    if (bits & 1 << DX_STAGE_REDUCE && !(bits & 1 << DX_STAGE_CLUSTER))
        return dx_err_set(err, -EINVAL, "--stages: found '%s', expected cluster before reduce",
                          list);
    if (bits & 1 << DX_STAGE_REFINE && !(bits & 1 << DX_STAGE_GROW))
        return dx_err_set(err, -EINVAL, "--stages: found '%s', expected grow before refine", list);
    return 0;
}

static int run(const struct dx_mesh_job *job, void *config, struct dx_err *err)
{
    struct dx_smooth_job_config *c = config;
    const int bits = c->stages ? parse_stages(c->stages) : (1 << DX_N_SMOOTH_STAGES) - 1;
    const int rc = check_stages(bits, c->stages, err);

    return rc < 0 ? rc : dx_smooth_job_run(job, c, (unsigned)bits, err);
}

const struct dx_mesh_mode dx_mesh_mode_smooth = {
    .name = "smooth",
    .about = "with noise, smoothed and thinned: Mederos, Velho and de Figueiredo 2004.\n",
    .help = help,
    .options = options,
    .config_len = sizeof(struct dx_smooth_job_config),
    .point_len = 260, /* meshing all points: half-edges, neighbours, the clouds of two stages */
    .defaults = defaults,
    .run = run,
};
