/* A fitted separable model: its memory, its directions, and the geometry made of it. */
#include "core/grid/fit_model.h"

#include "core/base/trig.h"

#include <errno.h>
#include <stdlib.h>

int dx_fit_model_init(struct dx_fit_model *m, enum dx_model kind, const struct dx_points *points)
{
    size_t width = points->width, height = points->height;
    double *room = calloc(4 * width + 4 * height, sizeof(*room));

    *m = (struct dx_fit_model){.kind = kind, .rms = INFINITY, .room = room};
    if (!room)
        return -ENOMEM;
    m->col = (struct dx_fit_axis){points->width, room, room + width, room + 2 * width, 0};
    m->saved = room + 3 * width;
    room += 4 * width;
    m->row = (struct dx_fit_axis){points->height, room, room + height, room + 2 * height, 0};
    m->offset = room + 3 * height;
    return 0;
}

void dx_fit_model_fini(struct dx_fit_model *m)
{
    free(m->room);
    m->room = NULL;
}

/* Direction in the frame that turns with the column: what a spinning row table holds. */
static void row_direction(const struct dx_fit_model *m, uint32_t row, double dir[3])
{
    double s, c, se, ce;

    dx_sincos(m->offset[row], &s, &c);
    dx_sincos(m->row.value[row], &se, &ce);
    dir[0] = ce * c;
    dir[1] = ce * s;
    dir[2] = se;
}

void dx_fit_model_direction(const struct dx_fit_model *m, uint32_t row, uint32_t col, double dir[3])
{
    if (m->kind == DX_MODEL_SPINNING) {
        double d[3], s, c;

        row_direction(m, row, d);
        dx_sincos(m->col.value[col], &s, &c);
        dir[0] = d[0] * c - d[1] * s;
        dir[1] = d[0] * s + d[1] * c;
        dir[2] = d[2];
    } else {
        double x = m->col.value[col], y = m->row.value[row];
        double z = 1 / sqrt(x * x + y * y + 1);

        dir[0] = x * z;
        dir[1] = y * z;
        dir[2] = z;
    }
}

static void fill_spinning(struct dx_geometry *g, const struct dx_fit_model *m)
{
    float *t = g->table;

    for (uint32_t col = 0; col < g->width; col++, t += 2) {
        double s, c;

        dx_sincos(m->col.value[col], &s, &c);
        t[0] = (float)c;
        t[1] = (float)s;
    }
    for (uint32_t row = 0; row < g->height; row++, t += 6) {
        double d[3];

        row_direction(m, row, d);
        for (int k = 0; k < 3; k++)
            t[k] = (float)d[k];
    }
}

static void fill_pinhole(struct dx_geometry *g, const struct dx_fit_model *m)
{
    for (uint32_t col = 0; col < g->width; col++)
        g->table[col] = (float)m->col.value[col];
    for (uint32_t row = 0; row < g->height; row++)
        g->table[g->width + row] = (float)m->row.value[row];
}

int dx_fit_to_separable(struct dx_geometry **out, const struct dx_fit_model *m)
{
    int rc = dx_geometry_new(out, m->kind, m->row.n, m->col.n);

    if (rc)
        return rc;
    if (m->kind == DX_MODEL_SPINNING)
        fill_spinning(*out, m);
    else
        fill_pinhole(*out, m);
    return 0;
}
