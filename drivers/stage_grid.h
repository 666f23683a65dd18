/*
 * The grid of a line scanner on a turning stage: which value of a scan is which row, and the
 * geometry that says where its dexels look.
 *
 * The scanner's plane cuts the stage's axis, so each scan has two halves, on either side of the
 * zenith. A row is a value's own beam: direction and origin are those of the mount, and a column is
 * an angle of the stage, so the spinning model carries an offset mount exactly as long as a row
 * belongs to one half. There are three layouts:
 *
 *   front    the half that looks forward; the other is left out
 *   layers   rows of the front half, three empty rows, rows of the back half: two surfaces, each
 *            exact for any mount
 *   joined   both halves in the same rows, the back one in columns half a turn further on. Exact
 *            with the spinning model where the mount lies on the axis and its plane is upright;
 *            else only where the planes carry the points themselves (`exact`)
 */
#ifndef DX_STAGE_GRID_H
#define DX_STAGE_GRID_H

#include "drivers/stage.h"

#define DX_STAGE_NO_ROW UINT32_MAX

enum dx_stage_layout { DX_STAGE_FRONT, DX_STAGE_LAYERS, DX_STAGE_JOINED };

struct dx_stage_grid {
    enum dx_stage_layout layout;
    struct dx_geometry *geometry;
    uint32_t n;         /* values of a scan */
    uint32_t *row;      /* [n] or DX_STAGE_NO_ROW: the value is left out */
    bool *back;         /* [n] */
    double *dir;        /* [3 n] at stage angle 0 */
    double origin[3];   /* of all beams, at stage angle 0 */
    uint32_t width;     /* of the geometry */
    uint32_t turn;      /* columns of a whole turn; even */
    uint32_t sweep;     /* columns of a sweep of the stage */
    double low_rad;     /* where column 0 begins */
    double columns_rad; /* columns in a radian */
};

/* NULL, or why no scanner that sits so sweeps anything: angles are [roll, pitch, yaw] in degrees.
 */
const char *dx_stage_grid_check(const double angles_deg[3]);

/* Columns of a whole turn; even. */
uint32_t dx_stage_grid_turn(const struct dx_stage_config *config,
                            const struct dx_line_shape *shape);

/* -EINVAL with a text (not possible), -ENOMEM. */
int dx_stage_grid_init(struct dx_stage_grid *g, const struct dx_stage_config *config,
                       const struct dx_line_shape *shape, struct dx_err *err);
void dx_stage_grid_fini(struct dx_stage_grid *g);

#endif
