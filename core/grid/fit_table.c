/*
 * Table model: each dexel its own direction. Dexels without a return take the direction of the best
 * separable model, plus the departures from it of the nearest returns left, right, above and below,
 * weighted by 1 / distance: an extrapolation that keeps the steps of the grid.
 */
#include "core/grid/fit_model.h"

#include <errno.h>
#include <stdlib.h>

struct filler {
    const struct dx_fit_model *model;
    const struct dx_points *points;
    float *sum;        /* departures [n][3], then weights [n] */
    uint32_t *nearest; /* row of the last return met in each column, plus 1 */
};

static void own_direction(const double *p, double dir[3])
{
    double r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);

    for (int k = 0; k < 3; k++)
        dir[k] = p[k] / r;
}

/* Adds to dexel (row, col) the departure of the return at (row2, col2). */
static void add_departure(struct filler *f, uint32_t row, uint32_t col, uint32_t row2,
                          uint32_t col2)
{
    size_t width = f->points->width, n = width * f->points->height, k = row * width + col;
    uint32_t distance = row2 > row ? row2 - row : row - row2;
    double own[3], model[3];

    distance += col2 > col ? col2 - col : col - col2;
    own_direction(f->points->xyz + 3 * (row2 * width + col2), own);
    dx_fit_model_direction(f->model, row2, col2, model);
    for (int i = 0; i < 3; i++)
        f->sum[3 * k + (size_t)i] += (float)((own[i] - model[i]) / distance);
    f->sum[3 * n + k] += 1.0f / (float)distance;
}

/* Walks the grid forwards (from left and above) or backwards. */
static void sweep(struct filler *f, bool forwards)
{
    uint32_t height = f->points->height, width = f->points->width;

    for (uint32_t col = 0; col < width; col++)
        f->nearest[col] = 0;
    for (uint32_t i = 0; i < height; i++) {
        uint32_t row = forwards ? i : height - 1 - i, beside = 0;

        for (uint32_t j = 0; j < width; j++) {
            uint32_t col = forwards ? j : width - 1 - j;

            if (dx_fit_valid(f->points->xyz + 3 * ((size_t)row * width + col))) {
                f->nearest[col] = row + 1;
                beside = col + 1;
                continue;
            }
            if (beside)
                add_departure(f, row, col, row, beside - 1);
            if (f->nearest[col])
                add_departure(f, row, col, f->nearest[col] - 1, col);
        }
    }
}

static void fill_table(float *table, const struct filler *f)
{
    size_t width = f->points->width, n = width * f->points->height;

    for (size_t k = 0; k < n; k++) {
        const double *p = f->points->xyz + 3 * k;
        double dir[3];

        if (dx_fit_valid(p)) {
            own_direction(p, dir);
        } else {
            dx_fit_model_direction(f->model, (uint32_t)(k / width), (uint32_t)(k % width), dir);
            for (size_t i = 0; i < 3 && f->sum[3 * n + k] > 0; i++)
                dir[i] += (double)(f->sum[3 * k + i] / f->sum[3 * n + k]);
            if (dx_fit_valid(dir))
                own_direction(dir, dir);
        }
        for (size_t i = 0; i < 3; i++)
            table[3 * k + i] = (float)dir[i];
    }
}

int dx_fit_to_table(struct dx_geometry **out, const struct dx_fit_model *m,
                    const struct dx_points *points)
{
    size_t n = (size_t)points->height * points->width;
    struct filler f = {m, points, NULL, NULL};
    int rc = dx_geometry_new(out, DX_MODEL_TABLE, points->height, points->width);

    if (rc)
        return rc;
    f.sum = calloc(4 * n, sizeof(*f.sum));
    f.nearest = calloc(points->width, sizeof(*f.nearest));
    if (f.sum && f.nearest) {
        sweep(&f, true);
        sweep(&f, false);
        fill_table((*out)->table, &f);
    } else {
        rc = -ENOMEM;
        dx_geometry_unref(*out);
        *out = NULL;
    }
    free(f.nearest);
    free(f.sum);
    return rc;
}
