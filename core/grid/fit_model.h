/*
 * What the parts of the geometry fit share: the separable models (a value for each column and each
 * row) and the tools for one such axis. Internal to core/grid/fit*.c. Scratch memory is allocated
 * once a fit.
 */
#ifndef DX_FIT_MODEL_H
#define DX_FIT_MODEL_H

#include "core/grid/fit.h"

/* Values along one side of the grid: azimuths, elevations (radians) or tangents. */
struct dx_fit_axis {
    uint32_t n;
    double *value;
    double *weight; /* 0: no dexel of this line has a return; the value is interpolated */
    double *scratch;
    double step; /* signed mean */
};

/* A fitted separable model. `offset` (rows; azimuth) is of spinning alone. */
struct dx_fit_model {
    enum dx_model kind;
    struct dx_fit_axis col, row;
    double *offset, *saved;
    double rms;   /* residual in dexels; INFINITY when the model cannot hold the points */
    double *room; /* what the pointers above point into */
};

/* To (-pi, pi], for |a| below a few turns. */
double dx_fit_wrap_angle(double a);

/* Fills values of weight 0 linearly from their neighbours (at the ends by the slope of the nearest
 * known ones) and sets `step`. Azimuths are made continuous first. False when fewer than two lines
 * are known and the axis has more than one. */
bool dx_fit_axis_complete(struct dx_fit_axis *axis, bool azimuth);

/* Sum of the squared departures from even steps, in steps. */
double dx_fit_axis_irregularity(const struct dx_fit_axis *axis);

/* The step to express residuals in: the axis' own, or the other's when it has a single line. */
double dx_fit_step(const struct dx_fit_axis *axis, const struct dx_fit_axis *other);

/* Errors: -ENOMEM. A model that does not suit the points is not an error: its rms is INFINITY. */
int dx_fit_model_init(struct dx_fit_model *m, enum dx_model kind, const struct dx_points *points);
void dx_fit_model_fini(struct dx_fit_model *m);
int dx_fit_spinning(struct dx_fit_model *m, const struct dx_points *points);
void dx_fit_pinhole(struct dx_fit_model *m, const struct dx_points *points);

/* Unit direction of a dexel under the model. */
void dx_fit_model_direction(const struct dx_fit_model *m, uint32_t row, uint32_t col,
                            double dir[3]);

/* The geometries. Table: the points' own directions; where there is none, the model's, corrected by
 * what the nearest returns depart from it. Errors: -EINVAL, -ENOMEM. */
int dx_fit_to_separable(struct dx_geometry **out, const struct dx_fit_model *m);
int dx_fit_to_table(struct dx_geometry **out, const struct dx_fit_model *m,
                    const struct dx_points *points);

#endif
