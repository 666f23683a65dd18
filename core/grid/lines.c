/* Weights of lines by least squares, from the directions. */
#include "core/grid/lines.h"

#include <math.h>

#define ONE (1 << 24)

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void dx_lines_direction(const struct dx_geometry *g, uint32_t row, uint32_t col, double d[3])
{
    if (g->model == DX_MODEL_PINHOLE) {
        d[0] = (double)g->table[col];
        d[1] = (double)g->table[(size_t)g->width + row];
        d[2] = 1;
    } else {
        dx_geometry_direction(g, row, col, d);
    }
}

static uint32_t weight(double w)
{
    w = rint(ONE * w); /* more than 1 only in crooked tables; a residual must fit 62 bits */
    return w > 0 ? (w < ONE ? (uint32_t)w : ONE) : 0;
}

static struct dx_line line_of(const double before[3], const double d[3], const double after[3])
{
    double a = dot(before, before), b = dot(before, after), c = dot(after, after);
    double p = dot(d, before), s = dot(d, after), det = a * c - b * b;

    if (!(det > 0))
        return (struct dx_line){0, 0};
    return (struct dx_line){weight((p * c - s * b) / det), weight((s * a - p * b) / det)};
}

/* Row or column x + d of n; -1: outside the grid. */
static int64_t neighbour(uint32_t x, int d, uint32_t n, bool wrap)
{
    int64_t y = (int64_t)x + d;

    if (wrap)
        return (y + n) % n;
    return y >= 0 && y < n ? y : -1;
}

struct dx_line dx_lines_at(const struct dx_geometry *g, uint32_t i, uint32_t j, int di, int dj)
{
    double d[3][3];

    for (int k = -1; k <= 1; k++) {
        int64_t row = neighbour(i, k * di, g->height, false);
        int64_t col = neighbour(j, k * dj, g->width, g->wrap);

        if (row < 0 || col < 0)
            return (struct dx_line){0, 0};
        dx_lines_direction(g, (uint32_t)row, (uint32_t)col, d[k + 1]);
    }
    return line_of(d[0], d[1], d[2]);
}

void dx_lines_fill(struct dx_line *line, const struct dx_geometry *g, enum dx_edge e,
                   bool per_dexel)
{
    /* rows and columns to the neighbour after; the one before is opposite */
    static const int step[DX_N_EDGES][2] = {{0, 1}, {1, 0}, {1, 1}, {1, -1}};

    if (g->width < 3) /* no line of three columns: all stay 0 */
        return;
    for (uint32_t i = 0; i < g->height; i++) {
        if (!per_dexel)
            line[i] = dx_lines_at(g, i, 1, step[e][0], step[e][1]);
        for (uint32_t j = 0; per_dexel && j < g->width; j++)
            line[(size_t)i * g->width + j] = dx_lines_at(g, i, j, step[e][0], step[e][1]);
    }
}
