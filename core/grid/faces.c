/* Orientation of directions: folded cells, struts, polar fans. */
#include "core/grid/faces.h"

#include "core/grid/strut.h"
#include "core/grid/tile.h"

#include <errno.h>
#include <stdlib.h>

int dx_faces_find_folds(uint64_t **folded, const struct dx_geometry *g)
{
    struct dx_tiling t;
    uint64_t *bits;
    size_t n;

    *folded = NULL;
    if (g->model != DX_MODEL_TABLE)
        return 0;
    dx_tiling_init(&t, g->height, g->width, g->wrap);
    n = (size_t)t.cell_rows * t.cell_cols;
    bits = calloc(n / 64 + 1, sizeof(uint64_t));
    if (!bits)
        return -ENOMEM;
    for (size_t k = 0; k < n; k++) {
        int sign =
            dx_geometry_cell_sign(g, (uint32_t)(k / t.cell_cols), (uint32_t)(k % t.cell_cols));

        if (sign != (g->flip ? 1 : -1))
            bits[k / 64] |= 1ull << (k % 64);
    }
    *folded = bits;
    return 0;
}

/* A triangle's plane on the unit sphere must pass the scanner at half its radius at the least: the
 * sign alone of a long thin one is the rounding of the table's f32, and an even grid's columns may
 * differ a little from the one that is asked. Ordinary triangles pass near 1. */
#define LEAST_DISTANCE 0.5

/* Whether the spherical triangle of three directions runs as a cell's good abc does, and its plane
 * passes at `distance` from the scanner at the least. */
static bool faces_scanner(const struct dx_geometry *g, double d[3][3], double distance)
{
    double u[3], v[3], n[3], det;

    for (int k = 0; k < 3; k++) {
        u[k] = d[1][k] - d[0][k];
        v[k] = d[2][k] - d[0][k];
    }
    n[0] = u[1] * v[2] - u[2] * v[1];
    n[1] = u[2] * v[0] - u[0] * v[2];
    n[2] = u[0] * v[1] - u[1] * v[0];
    det = d[0][0] * n[0] + d[0][1] * n[1] + d[0][2] * n[2];
    det = g->flip ? det : -det;
    return det > 0 && det * det > distance * distance * (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
}

bool dx_faces_triangle(const struct dx_geometry *g, const uint32_t at[3][2])
{
    double d[3][3];

    for (int k = 0; k < 3; k++)
        dx_geometry_direction(g, at[k][0], at[k][1], d[k]);
    return faces_scanner(g, d, LEAST_DISTANCE);
}

/* False only for a triangle of dexels of the grid that looks away. */
static bool triangle_faces(const struct dx_geometry *g, const struct dx_strut_corner corner[3],
                           uint32_t i, uint32_t j)
{
    double d[3][3];

    for (int k = 0; k < 3; k++) {
        int64_t row = (int64_t)i + corner[k].row, col = (int64_t)j + corner[k].col;

        if (row < 0 || row >= g->height || (!g->wrap && (col < 0 || col >= g->width)))
            return true;
        dx_geometry_direction(g, (uint32_t)row, (uint32_t)(col + g->width) % g->width, d[k]);
    }
    return faces_scanner(g, d, LEAST_DISTANCE);
}

/* One side at a time makes every triangle that two sides can. */
bool dx_faces_span(const struct dx_geometry *g, bool across, uint8_t len, uint32_t i, uint32_t j)
{
    struct dx_strut_corner triangle[DX_STRUT_MAX_TRIANGLES][3];

    for (int side = 1; side < DX_STRUT_FIRST_SIDES + DX_STRUT_SECOND_SIDES; side++) {
        const struct dx_strut s = {
            .across = across,
            .len = len,
            .first = (uint8_t)(side < DX_STRUT_FIRST_SIDES ? side : 0),
            .second = (uint8_t)(side < DX_STRUT_FIRST_SIDES ? 0 : side - DX_STRUT_FIRST_SIDES),
        };
        unsigned n = dx_strut_triangles(triangle, dx_strut_code(&s));

        for (unsigned k = 0; k < n; k++)
            if (!triangle_faces(g, triangle[k], i, j))
                return false;
    }
    return true;
}

bool dx_faces_fan(const struct dx_geometry *g, uint32_t row, bool below)
{
    for (uint32_t j = 1; j + 1 < g->width; j++) {
        double d[3][3];

        dx_geometry_direction(g, row, 0, d[0]);
        dx_geometry_direction(g, row, below ? j + 1 : j, d[1]);
        dx_geometry_direction(g, row, below ? j : j + 1, d[2]);
        if (!faces_scanner(g, d, 0)) /* all in one plane: the sign is the row's own */
            return false;
    }
    return true;
}
