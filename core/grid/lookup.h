/*
 * From a point to the dexel that looks at it, for geometries whose columns and rows are separable
 * and share one origin: spinning without row offsets, and pinhole. A dexel's share of the view
 * reaches half way to its neighbours' directions, and as far beyond the outermost ones. Constant
 * once made; any thread.
 */
#ifndef DX_LOOKUP_H
#define DX_LOOKUP_H

#include "core/grid/geometry.h"

/* One side of the grid: line k holds the values edge[k] <= v < edge[k + 1]. */
struct dx_lookup_axis {
    uint32_t n;
    double *edge;    /* n + 1, ascending */
    uint32_t *first; /* of each bin: no value of the bin lies on a line before this one */
    uint32_t n_bins;
    double scale; /* bins by value */
};

struct dx_lookup {
    enum dx_model model;
    struct dx_lookup_axis col, row;
    double col_sign, row_sign; /* -1: the device counts the other way */
    double turn0;              /* spinning: where column 0 begins (quadrants) */
};

/* Allocates its tables. Errors: -EINVAL (model, row offsets, columns or rows that do not go one
 * way or lie half a turn apart), -ENOMEM. */
int dx_lookup_init(struct dx_lookup *l, const struct dx_geometry *g);
void dx_lookup_fini(struct dx_lookup *l);

/* The dexel of a finite point at distance r > 0 from the origin; false: outside the view. */
bool dx_lookup_find(const struct dx_lookup *l, const double p[3], double r, uint32_t *row,
                    uint32_t *col);

#endif
