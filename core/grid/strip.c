/* Columns of the tables, and rows of points from them. */
#include "core/grid/strip.h"

#include <string.h>

static void fill_col(struct dx_strip *s, uint32_t j, uint32_t col)
{
    const float *table = s->geometry->table;

    if (s->geometry->model == DX_MODEL_SPINNING) {
        s->turn.c[j] = table[2 * (size_t)col];
        s->turn.s[j] = table[2 * (size_t)col + 1];
    } else if (s->geometry->model == DX_MODEL_PINHOLE) {
        s->beam.x[j] = table[col];
        s->beam.z[j] = 1;
    }
}

void dx_strip_init(struct dx_strip *s, const struct dx_geometry *g, const struct dx_rows *rows,
                   int64_t col0)
{
    const int64_t width = g->width;

    memset(s, 0, sizeof(*s));
    s->geometry = g;
    s->rows = rows;
    for (uint32_t j = 0; j < DX_ROWS_N; j++) {
        int64_t col = col0 + j;

        if (g->wrap)
            col = (col % width + width) % width;
        s->col[j] = col >= 0 && col < width ? (int32_t)col : -1;
        if (s->col[j] >= 0)
            fill_col(s, j, (uint32_t)col);
    }
    s->n_next[DX_ROWS_N - 1] = 1;
    for (uint32_t j = DX_ROWS_N - 1; j-- > 0;)
        s->n_next[j] = s->col[j + 1] == s->col[j] + 1 ? (uint8_t)(s->n_next[j + 1] + 1) : 1;
}

/* The vectors that ranges stretch: of a pinhole or a table. */
static void fill_beams(struct dx_strip *s, uint32_t row)
{
    const struct dx_geometry *g = s->geometry;

    for (uint32_t j = 0; g->model == DX_MODEL_PINHOLE && j < DX_ROWS_N; j++)
        s->beam.y[j] = g->table[(size_t)g->width + row];
    for (uint32_t j = 0; g->model == DX_MODEL_TABLE && j < DX_ROWS_N; j++) {
        const float *v = g->table + 3 * ((size_t)row * g->width + (uint32_t)s->col[j]);

        if (s->col[j] < 0)
            continue;
        s->beam.x[j] = v[0];
        s->beam.y[j] = v[1];
        s->beam.z[j] = v[2];
    }
}

static const float *spinning_row(const struct dx_geometry *g, uint32_t row)
{
    return g->table + 2 * (size_t)g->width + 6 * (size_t)row;
}

void dx_strip_points(struct dx_row_points *out, struct dx_strip *s, uint32_t row, const float *r)
{
    if (s->geometry->model == DX_MODEL_SPINNING) {
        s->rows->turn(out, spinning_row(s->geometry, row), &s->turn, r);
        return;
    }
    fill_beams(s, row);
    s->rows->stretch(out, &s->beam, r);
}

void dx_strip_beams(struct dx_row_points *out, struct dx_strip *s, uint32_t row)
{
    float from_origin[6] = {0}, one[DX_ROWS_N];

    if (s->geometry->model == DX_MODEL_SPINNING) {
        memcpy(from_origin, spinning_row(s->geometry, row), 3 * sizeof(*from_origin));
        for (uint32_t j = 0; j < DX_ROWS_N; j++)
            one[j] = 1;
        s->rows->turn(out, from_origin, &s->turn, one);
    } else {
        fill_beams(s, row);
        *out = s->beam;
    }
    if (s->geometry->model != DX_MODEL_PINHOLE)
        s->rows->unit(out);
}
