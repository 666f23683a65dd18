/*
 * A simulated scan with its truth, for measuring meshes (ALGORITHMS 6.4 and 7.1): what every beam
 * meets, which edges of the grid lie on the surface and which leave it, frames drawn with noise,
 * and the mesh of the last frame. Owned by one thread. Everything follows from the scene, the size,
 * the drawing's settings and its seed.
 */
#ifndef DX_QUALITY_RIG_H
#define DX_QUALITY_RIG_H

#include "core/grid/gates.h"
#include "core/grid/terrain.h"
#include "drivers/synth/sight.h"

/* What the truth says of a cell. */
enum dx_quality_class {
    DX_QUALITY_SEEN = 1,   /* a surface at each corner */
    DX_QUALITY_SMOOTH = 2, /* seen, and all six edges lie on the surface */
    DX_QUALITY_CROSSED =
        4, /* smooth, and its corners are not all of one face: a crease runs through
            */
};

struct dx_quality_rig {
    struct dx_scene_config scene; /* with the settings of the last drawing */
    struct dx_geometry *geometry;
    struct dx_tiling tiling;
    struct dx_sight
        *sights; /* height rows of width + 2, a column before and one after the grid's */
    /* Bit e of rough[i * width + j]: edge e (enum dx_edge) of cell (i, j) leaves the surface, by
     * more than the larger of 3 cm and the spacing of its ends. Also set where an end sees nothing.
     */
    uint8_t *rough;
    uint8_t *class; /* enum dx_quality_class bits of cell i * cell_cols + j */
    float *mid[2];  /* the true range at the middle of the AC, the BD diagonal of cell (i, j) */
    struct dx_plane frame;
    uint64_t frame_number;
    struct dx_terrain *terrain; /* of the last mesh; NULL before */
    uint8_t *code;              /* enum dx_cell of cell i * cell_cols + j, of the last mesh */
};

/* What `scene` says, but without noise, drop-outs and mixed pixels: those are drawn. Errors:
 * -EINVAL, -ENOMEM. */
int dx_quality_rig_new(struct dx_quality_rig **out, const struct dx_scene_config *scene);
void dx_quality_rig_free(struct dx_quality_rig *rig);

/* Fills the frame: noise s0 + s1 r + s2 r^2, drop-outs and mixed pixels as the scene's sensor makes
 * them (drivers/synth/scene.h). */
struct dx_quality_draw {
    double sigma[3], dropout, mixed;
    uint64_t seed;
    uint64_t frame; /* of one seed: each has noise of its own; what stands in the scene stays */
};

void dx_quality_rig_draw(struct dx_quality_rig *rig, const struct dx_quality_draw *draw);

/* The default parameters with the true noise of the last drawing. */
struct dx_terrain_params dx_quality_rig_params(const struct dx_quality_rig *rig);

/* Meshes the frame. Errors: of dx_terrain_new. */
int dx_quality_rig_mesh(struct dx_quality_rig *rig, const struct dx_terrain_params *params);

/* Whether the last drawing mixed two surfaces in dexel k. */
bool dx_quality_rig_mixed(const struct dx_quality_rig *rig, uint32_t row, uint32_t col);

static inline const struct dx_sight *dx_quality_sight(const struct dx_quality_rig *rig,
                                                      uint32_t row, uint32_t col)
{
    return rig->sights + (size_t)row * (rig->geometry->width + 2) + 1 + col;
}

/* Dexels a, b, c, d of cell (i, j). */
static inline void dx_quality_corners(const struct dx_quality_rig *rig, uint32_t i, uint32_t j,
                                      size_t corner[4])
{
    size_t width = rig->geometry->width, next = j + 1 < width ? j + 1 : 0;

    corner[0] = i * width + j;
    corner[1] = i * width + next;
    corner[2] = (i + 1) * width + next;
    corner[3] = (i + 1) * width + j;
}

/* A triangle of the last mesh: vertices as dexel ids, as index-plane places (columns run on past
 * the seam) and as points. */
struct dx_quality_triangle {
    uint64_t id[3];
    int64_t row[3], col[3];
    const float *point[3];
};

/* Calls `fn` for every triangle, tile by tile. Errors: -ENOMEM. */
int dx_quality_each_triangle(const struct dx_quality_rig *rig,
                             void (*fn)(void *ctx, const struct dx_quality_triangle *t), void *ctx);

#endif
