/*
 * Where a dexel looks: the map from (row, column, range) to a point in the scanner's own frame, in
 * metres. Three models; each is a blob of f32 tables, so that whoever holds the same bits computes
 * the same points. Immutable once made; shared between threads by reference count.
 *
 * The f32 operations, in this order, each rounded (no fused multiply-add); r = (float)range * unit:
 *   spinning  row table (dx,dy,dz, ox,oy,oz), column table (c, s):
 *             u = ox + r*dx, v = oy + r*dy, w = oz + r*dz;  x = u*c - v*s, y = u*s + v*c, z = w
 *   pinhole   column table (X), row table (Y):  x = r*X, y = r*Y, z = r       (r is depth along the
 * axis) table     dexel table (dx,dy,dz):           x = r*dx, y = r*dy, z = r*dz
 */
#ifndef DX_GEOMETRY_H
#define DX_GEOMETRY_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum dx_model {
    DX_MODEL_SPINNING = 1,
    DX_MODEL_PINHOLE = 2,
    DX_MODEL_TABLE = 3,
};

struct dx_geometry {
    atomic_uint refs;
    enum dx_model model;
    uint32_t height, width;
    bool wrap; /* column 0 follows the last column (seam closed) */
    bool flip; /* handedness: emit (a,c,b) for index-plane (a,b,c), so that faces see the scanner */
    uint8_t range_bytes; /* 2 or 4: what a range of this stream needs */
    bool exact;          /* planes of this stream carry the points themselves (plane.h: xyz) */
    float unit_m;        /* metres per range unit */
    double pose[12];     /* rows of [R|t], scanner to world; never applied to chunks */
    /*
     * The tables, one allocation of n_table floats:
     *   spinning  2 * width  (c, s of each column), then 6 * height (dx,dy,dz,ox,oy,oz of each row)
     *   pinhole   width (X), then height (Y)
     *   table     3 * height * width
     */
    size_t n_table;
    float *table;
};

/* Floats in the tables of a model; 0 for an unknown model or sizes out of bounds (plane.h). */
size_t dx_geometry_table_len(enum dx_model model, uint32_t height, uint32_t width);

/* Zeroed tables, identity pose, one reference. Errors: -EINVAL, -ENOMEM. */
int dx_geometry_new(struct dx_geometry **out, enum dx_model model, uint32_t height, uint32_t width);
struct dx_geometry *dx_geometry_ref(struct dx_geometry *g);
void dx_geometry_unref(struct dx_geometry *g); /* NULL is fine */

/* Evenly spaced spinning scanner: azimuth0/elevation0 of column/row 0 and steps, radians; every
 * beam from one origin. `wrap` is set when the columns cover 360 degrees to a tenth of a step. */
int dx_geometry_new_spinning(struct dx_geometry **out, uint32_t height, uint32_t width,
                             double azimuth0, double azimuth_step, double elevation0,
                             double elevation_step);

/* fx, fy, cx, cy in pixels, as in x = z (col - cx) / fx. */
int dx_geometry_new_pinhole(struct dx_geometry **out, uint32_t height, uint32_t width, double fx,
                            double fy, double cx, double cy);

/* Sets `flip` from the tables' own orientation (majority of cells). Call after filling the tables.
 */
void dx_geometry_orient(struct dx_geometry *g);

/* Orientation of cell (row, col) as the scanner sees a, b, c, d: +1, -1, or 0 where the directions
 * fold (its four corner triangles do not agree). */
int dx_geometry_cell_sign(const struct dx_geometry *g, uint32_t row, uint32_t col);

/* Unit direction of a dexel, in double (from the f32 tables). */
void dx_geometry_direction(const struct dx_geometry *g, uint32_t row, uint32_t col, double dir[3]);

/* Angle between the directions of two dexels, radians. For a pinhole this is the angle that the
 * edge rule uses: the step of the tangent table (ALGORITHMS 1.6), not the true angle. */
double dx_geometry_angle(const struct dx_geometry *g, uint32_t row0, uint32_t col0, uint32_t row1,
                         uint32_t col1);

/* The point of a dexel, as specified above. */
static inline void dx_geometry_point(const struct dx_geometry *g, uint32_t row, uint32_t col,
                                     uint32_t range, float p[3])
{
    float r = (float)range * g->unit_m;

    if (g->model == DX_MODEL_SPINNING) {
        const float *cs = g->table + 2 * (size_t)col;
        const float *d = g->table + 2 * (size_t)g->width + 6 * (size_t)row;
        float u = d[3] + r * d[0], v = d[4] + r * d[1];

        p[0] = u * cs[0] - v * cs[1];
        p[1] = u * cs[1] + v * cs[0];
        p[2] = d[5] + r * d[2];
    } else if (g->model == DX_MODEL_PINHOLE) {
        p[0] = r * g->table[col];
        p[1] = r * g->table[(size_t)g->width + row];
        p[2] = r;
    } else {
        const float *d = g->table + 3 * ((size_t)row * g->width + col);

        p[0] = r * d[0];
        p[1] = r * d[1];
        p[2] = r * d[2];
    }
}

/* A distance in units of the geometry, rounded; 0 when it does not fit its width. */
uint32_t dx_geometry_units(const struct dx_geometry *g, double range_m);

/* The finest 1-2-5 step (metres) at which `max_range_m` fits 16 bits; at least 1e-6. */
double dx_geometry_unit_for(double max_range_m);

/* Largest angle between a dexel's directions in the two, in units of the dexel's own angular step;
 * INFINITY when model, size or seam differ. A sequence RESETs above 0.5. */
double dx_geometry_departure(const struct dx_geometry *a, const struct dx_geometry *b);

/* Whether both make the same point, bit for bit, of each dexel and range, and stand at the same
 * pose. */
bool dx_geometry_is_same(const struct dx_geometry *a, const struct dx_geometry *b);

const char *dx_model_name(enum dx_model model);

#endif
