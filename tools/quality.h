/*
 * The quality figures of terrain mode (ALGORITHMS 6.4), each a function of a rig's last drawing and
 * mesh, and the themes that `dexel bench quality` makes tables of. Pure: the same rig gives the
 * same numbers. One thread.
 */
#ifndef DX_QUALITY_H
#define DX_QUALITY_H

#include "tools/quality_report.h"
#include "tools/quality_rig.h"

/* ---- figures ----------------------------------------------------------------------------------
 */

/* Of the cells that are smooth by the truth and have four samples, those with both triangles. */
struct dx_quality_coverage {
    uint64_t smooth, full;
};
struct dx_quality_coverage dx_quality_coverage(const struct dx_quality_rig *rig);

/* Triangles with an edge that leaves the surface (struct dx_quality_rig: rough), beside the cells
 * that see surface at four corners and are not smooth. */
struct dx_quality_veil {
    uint64_t discontinuities, triangles;
};
struct dx_quality_veil dx_quality_veil(const struct dx_quality_rig *rig);

/* Triangles with a mixed sample at a corner, and all others. Errors: -ENOMEM. */
struct dx_quality_mixed {
    uint64_t samples, touching, others;
};
int dx_quality_mixed(struct dx_quality_mixed *out, const struct dx_quality_rig *rig);

/* Area of the index plane that triangles cover, in half cells (they do not overlap: see topology).
 * Errors: -ENOMEM. */
int dx_quality_area(uint64_t *half_cells, const struct dx_quality_rig *rig);

/* How far the mesh is from the truth at the middle of full smooth cells, metres along the beam: all
 * of them, and those that a crease crosses. Root of the mean square. */
struct dx_quality_centre {
    uint64_t cells, crossed;
    double rms_m, crossed_rms_m;
};
struct dx_quality_centre dx_quality_centre(const struct dx_quality_rig *rig);

/* Share of smooth cells, full under both codes, whose diagonal differs. */
double dx_quality_flicker(const struct dx_quality_rig *rig, const uint8_t *code,
                          const uint8_t *other);

/* The same distance in sigmas of the true range, on the room's walls (HALL, OPEN) where the beam
 * meets them within `incidence_deg` of the normal. */
struct dx_quality_walls {
    uint64_t cells;
    double rms_sigma;
};
struct dx_quality_walls dx_quality_walls(const struct dx_quality_rig *rig, double incidence_deg);

/* The estimated noise beside the true one, at the 5th, 50th and 95th percentile of the ranges. */
struct dx_quality_noise {
    bool known;
    double sigma[3];
    double range_m[3], ratio[3];
};
/* Errors: -ENOMEM. */
int dx_quality_noise(struct dx_quality_noise *out, const struct dx_quality_rig *rig);

/* What may not be: all 0 but the first two. `flipped`: faces that do not see the scanner.
 * `covered_twice`: of 8 x 8 samples a cell of the index plane, those under two triangles. Errors:
 * -EOVERFLOW, -ENOMEM. */
struct dx_quality_topology {
    uint64_t points, triangles;
    uint64_t nonmanifold_edges, duplicate_directed_edges, flipped, covered_twice;
};
int dx_quality_topology(struct dx_quality_topology *out, const struct dx_quality_rig *rig);

/* A scene that stands still, frame after frame through one terrain. */
struct dx_quality_static {
    double rms_sigma; /* of the published array after the last frame, to the truth */
    double changed;   /* mean share of tiles that a frame changes, after the first `settling` */
};
/* Draws frames as `draw` says, with its seed, from number 0 on. Errors: of dx_terrain_new. */
int dx_quality_static(struct dx_quality_static *out, struct dx_quality_rig *rig,
                      const struct dx_terrain_params *params, const struct dx_quality_draw *draw,
                      uint32_t settling, uint32_t n_frames);

/* Root mean square distances of ranges from the true ones, in sigmas: on flat parts, within three
 * dexels of creases (cells that one crosses) and of silhouettes (cells that are not smooth), and at
 * the corners of the cells that a crease crosses. */
struct dx_quality_smooth {
    double flat, crease, silhouette, on_crease;
    double largest_move; /* of smoothed ranges from the samples, in sigmas */
};

/* Of a drawing's ranges, of the same smoothed, and (the bias) of the true ones smoothed as those
 * are. Errors: of dx_terrain_new, -ENOMEM. */
int dx_quality_smooth(struct dx_quality_smooth out[3], struct dx_quality_rig *rig,
                      const struct dx_quality_draw *draw);

/* ---- themes -----------------------------------------------------------------------------------
 */

struct dx_quality_run {
    struct dx_quality_report *report;
    uint64_t seed;
    bool quick; /* grids of half the rows and columns */
};

/* Measures and reports the tables of a theme. Errors: -ENOMEM, -EINVAL. */
typedef int dx_quality_theme(struct dx_quality_run *run);

dx_quality_theme dx_quality_theme_coverage, dx_quality_theme_veil, dx_quality_theme_mixed,
    dx_quality_theme_dropouts, dx_quality_theme_diagonals, dx_quality_theme_walls,
    dx_quality_theme_noise, dx_quality_theme_topology, dx_quality_theme_bytes,
    dx_quality_theme_static, dx_quality_theme_smooth, dx_quality_theme_lod;

/* A scene as the themes' tables name it; half the size when the run is quick. */
struct dx_quality_scan {
    enum dx_scene scene;
    uint32_t width, height;
    bool mirrored; /* the columns the other way round */
};
int dx_quality_run_rig(struct dx_quality_rig **out, const struct dx_quality_run *run,
                       const struct dx_quality_scan *scan);

#endif
