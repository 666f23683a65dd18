/* What a mesh of a scan may not be: counted on the welded mesh, and triangle by triangle. */
#include "tools/quality.h"

#include "tools/mesh_stats.h"
#include "tools/mesh_store.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

#define MM 1e-3

/* ---- the figure ------------------------------------------------------------------------------ */

static int weld(struct dx_mesh *mesh, const struct dx_quality_rig *rig)
{
    const struct dx_geometry *g = rig->geometry;
    struct dx_tile *tile = malloc(sizeof(*tile));
    struct dx_tile_mesh *one = malloc(sizeof(*one));
    struct dx_mesh_store *store = NULL;
    int rc = tile && one ? dx_mesh_store_new(&store, g->height, g->width, g->wrap, 0) : -ENOMEM;

    for (uint32_t k = 0; rc == 0 && k < dx_tiling_n_tiles(&rig->tiling); k++) {
        if (!dx_terrain_tile(rig->terrain, k, tile))
            continue;
        dx_tile_mesh_build(one, tile, &rig->tiling, g);
        rc = dx_mesh_store_set_mesh(store, one);
    }
    if (rc == 0) {
        dx_mesh_store_commit(store);
        rc = dx_mesh_store_weld(mesh, store);
    }
    dx_mesh_store_free(store);
    free(one);
    free(tile);
    return rc;
}

struct faces {
    const struct dx_tiling *tiling;
    struct dx_quality_topology *count;
    uint64_t *seen; /* a cell: which of its 8 x 8 samples are covered */
};

/* With normal n = (p1 - p0) x (p2 - p0), n.(o - p0) is -det(p0, p1, p2): positive where the face
 * sees the scanner. */
static bool sees_scanner(const struct dx_quality_triangle *t)
{
    double p[3][3];

    for (int m = 0; m < 3; m++)
        for (int x = 0; x < 3; x++)
            p[m][x] = (double)t->point[m][x];
    return p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) -
               p[0][1] * (p[1][0] * p[2][2] - p[1][2] * p[2][0]) +
               p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]) <
           0;
}

/* Samples of a cell inside the triangle, as bits. They lie at irrational places, so none is on an
 * edge between dexels. */
static uint64_t covered_samples(const struct dx_quality_triangle *t, int64_t i, int64_t j)
{
    uint64_t bits = 0;

    for (int s = 0; s < 64; s++) {
        const int row = s / 8, col = s % 8;
        double y = (double)i + (row + 0.41421356) / 8, x = (double)j + (col + 0.73205081) / 8;
        int sides = 0;

        for (int m = 0; m < 3; m++) {
            int n = (m + 1) % 3;
            double side = (double)(t->col[n] - t->col[m]) * (y - (double)t->row[m]) -
                          (double)(t->row[n] - t->row[m]) * (x - (double)t->col[m]);

            sides += side > 0 ? 1 : -1;
        }
        if (sides == 3 || sides == -3)
            bits |= 1ull << s;
    }
    return bits;
}

static int64_t least(const int64_t v[3])
{
    int64_t m = v[0] < v[1] ? v[0] : v[1];

    return m < v[2] ? m : v[2];
}

static int64_t most(const int64_t v[3])
{
    int64_t m = v[0] > v[1] ? v[0] : v[1];

    return m > v[2] ? m : v[2];
}

static void check_face(void *ctx, const struct dx_quality_triangle *t)
{
    struct faces *f = ctx;
    int64_t cols = f->tiling->cell_cols;

    f->count->flipped += !sees_scanner(t);
    for (int64_t i = least(t->row); i < most(t->row); i++)
        for (int64_t j = least(t->col); j < most(t->col); j++) {
            uint64_t *cell = &f->seen[i * cols + (j + cols) % cols];
            uint64_t bits = covered_samples(t, i, j);

            f->count->covered_twice += (uint64_t)__builtin_popcountll(*cell & bits);
            *cell |= bits;
        }
}

int dx_quality_topology(struct dx_quality_topology *out, const struct dx_quality_rig *rig)
{
    size_t n_cells = (size_t)rig->tiling.cell_rows * rig->tiling.cell_cols;
    struct faces f = {&rig->tiling, out, calloc(n_cells, sizeof(uint64_t))};
    struct dx_mesh mesh = {0};
    struct dx_mesh_stats stats = {0};
    int rc = f.seen ? weld(&mesh, rig) : -ENOMEM;

    *out = (struct dx_quality_topology){0};
    if (rc == 0)
        rc = dx_mesh_stats_compute(&stats, &mesh);
    if (rc == 0)
        rc = dx_quality_each_triangle(rig, check_face, &f);
    out->points = stats.points;
    out->triangles = stats.triangles;
    out->nonmanifold_edges = stats.nonmanifold_edges;
    out->duplicate_directed_edges = stats.duplicate_directed_edges;
    dx_mesh_fini(&mesh);
    free(f.seen);
    return rc;
}

/* ---- the theme ------------------------------------------------------------------------------- */

static int topology_row(struct dx_quality_table *t, struct dx_quality_rig *rig,
                        const struct dx_terrain_params *p, const char *note)
{
    struct dx_quality_row *row = dx_quality_row(t, &rig->scene);
    struct dx_quality_topology top;
    int rc = dx_quality_rig_mesh(rig, p);

    if (rc == 0)
        rc = dx_quality_topology(&top, rig);
    if (rc)
        return rc;
    snprintf(row->note, sizeof(row->note), "%s", note);
    row->value[0] = (double)top.points;
    row->value[1] = (double)top.triangles;
    row->value[2] = (double)(top.nonmanifold_edges + top.duplicate_directed_edges);
    row->value[3] = (double)top.flipped;
    row->value[4] = (double)top.covered_twice;
    for (unsigned k = 2; k < 5; k++)
        dx_quality_hold(row, k, DX_QUALITY_AT_MOST, 0);
    return 0;
}

static int topology_rows(struct dx_quality_table *t, struct dx_quality_rig *rig, uint64_t seed)
{
    const struct dx_quality_draw mild = {
        .sigma = {2 * MM}, .dropout = 0.05, .mixed = 0.3, .seed = seed};
    const struct dx_quality_draw wild = {
        .sigma = {10 * MM, 0, 0.5 * MM}, .dropout = 0.2, .mixed = 0.7, .seed = seed};
    struct dx_terrain_params p;
    int rc;

    dx_quality_rig_draw(rig, &mild);
    p = dx_quality_rig_params(rig);
    rc = topology_row(t, rig, &p, "");
    if (rc < 0)
        return rc;
    dx_quality_rig_draw(rig, &wild);
    p = dx_quality_rig_params(rig);
    p.bridge = 2;
    p.mixed = DX_MIXED_STRICT;
    return topology_row(t, rig, &p, "bridge 2, strict");
}

int dx_quality_theme_topology(struct dx_quality_run *run)
{
    struct dx_quality_table t = {
        .theme = "topology",
        .title = "Topology",
        .text =
            "Edges of more than two triangles or run twice in one direction, faces that do not\n"
            "see the scanner, and samples of the index plane (8 x 8 a cell) under two\n"
            "triangles. By the default rules on a plausible scan, and with two missing dexels\n"
            "bridged and the strict filter of mixed samples on a bad one. All must be 0.",
        .column = {{"points", "points", 0},
                   {"triangles", "triangles", 0},
                   {"bad edges", "bad_edges", 0},
                   {"flipped", "flipped", 0},
                   {"doubly covered", "covered_twice", 0}},
    };
    int rc = 0;

    for (unsigned scene = 0; rc == 0 && scene < DX_N_SCENES; scene++) {
        struct dx_quality_rig *rig = NULL;
        struct dx_scene_config c;

        dx_scene_config_default(&c, (enum dx_scene)scene);
        rc = dx_quality_run_rig(&rig, run,
                                &(struct dx_quality_scan){c.scene, c.width, c.height, false});
        if (rc == 0)
            rc = topology_rows(&t, rig, run->seed);
        dx_quality_rig_free(rig);
    }
    if (rc == 0)
        dx_quality_report_table(run->report, &t);
    return rc;
}
