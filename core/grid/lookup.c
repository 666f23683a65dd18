/*
 * Columns and rows are told by numbers that grow with the angle but need no trigonometry: of the
 * azimuth, the place on a square around the origin (0 to 4, a quadrant each); of the elevation, its
 * sine; of a pinhole, the tangents. The edges between lines are the same numbers of the bisectors,
 * and bins of equal width lead from a value to its line.
 */
#include "core/grid/lookup.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

#define BINS_PER_LINE 4
/* Beyond every sine, for a row that reaches over the pole. */
#define PAST_POLE 2.0

struct vec2 {
    double x, y;
};

static struct vec2 unit(double x, double y)
{
    double len = sqrt(x * x + y * y);

    return (struct vec2){x / len, y / len};
}

static double cross(struct vec2 a, struct vec2 b)
{
    return a.x * b.y - a.y * b.x;
}

/* Less than half a turn on, so that there is a half way. */
static bool follows(struct vec2 a, struct vec2 b)
{
    return cross(a, b) > 0 && a.x * b.x + a.y * b.y > -0.999;
}

/* Half way between two directions less than half a turn apart. */
static struct vec2 bisector(struct vec2 a, struct vec2 b)
{
    return unit(a.x + b.x, a.y + b.y);
}

/* `b` on the other side of the axis `a`. */
static struct vec2 mirror(struct vec2 b, struct vec2 a)
{
    double along = 2 * (a.x * b.x + a.y * b.y);

    return (struct vec2){along * a.x - b.x, along * a.y - b.y};
}

/* ---- axes ----------------------------------------------------------------------------------- */

static uint32_t bin_of(const struct dx_lookup_axis *a, double v)
{
    double bin = (v - a->edge[0]) * a->scale;

    return bin < a->n_bins ? (uint32_t)bin : a->n_bins - 1;
}

static int axis_init(struct dx_lookup_axis *a, uint32_t n)
{
    a->n = n;
    a->n_bins = BINS_PER_LINE * n;
    a->edge = calloc((size_t)n + 1, sizeof(*a->edge));
    a->first = calloc(a->n_bins, sizeof(*a->first));
    return a->edge && a->first ? 0 : -ENOMEM;
}

/* Once the edges are there: -EINVAL unless they ascend. Since bin_of() grows with its value, a line
 * that ends in an earlier bin holds no value of this one. */
static int axis_complete(struct dx_lookup_axis *a)
{
    uint32_t line = 0;

    for (uint32_t k = 0; k < a->n; k++)
        if (!(a->edge[k] < a->edge[k + 1]))
            return -EINVAL;
    a->scale = a->n_bins / (a->edge[a->n] - a->edge[0]);
    for (uint32_t bin = 0; bin < a->n_bins; bin++) {
        while (line + 1 < a->n && bin_of(a, a->edge[line + 1]) < bin)
            line++;
        a->first[bin] = line;
    }
    return 0;
}

/* The line of a value; a->n when there is none. */
static uint32_t axis_find(const struct dx_lookup_axis *a, double v)
{
    uint32_t line;

    if (!(v >= a->edge[0] && v < a->edge[a->n]))
        return a->n;
    line = a->first[bin_of(a, v)];
    while (v >= a->edge[line + 1])
        line++;
    return line;
}

/* ---- spinning ------------------------------------------------------------------------------- */

/* Quadrants from the x axis to (x, y), on the square: 0 to 4, growing with the azimuth. */
static double quadrants(double x, double y)
{
    double sum = fabs(x) + fabs(y), part;

    if (sum == 0) /* on the axis: any column is right */
        return 0;
    part = y / sum;
    if (x < 0)
        return 2 - part;
    return y < 0 ? 4 + part : part;
}

/* The same from the beginning of column 0; less than 4. */
static double turned(const struct dx_lookup *l, double x, double y)
{
    double turn = quadrants(x, y) - l->turn0;

    turn = turn < 0 ? turn + 4 : turn;
    return turn < 4 ? turn : 0;
}

static struct vec2 col_direction(const struct dx_lookup *l, const struct dx_geometry *g,
                                 uint32_t col)
{
    const float *cs = g->table + 2 * (size_t)col;

    return unit((double)cs[0], l->col_sign * (double)cs[1]);
}

static int spinning_columns(struct dx_lookup *l, const struct dx_geometry *g)
{
    double *edge = l->col.edge;
    uint32_t n = g->width;
    struct vec2 first, last, begin, end;

    l->col_sign = 1;
    if (cross(col_direction(l, g, 0), col_direction(l, g, 1)) < 0)
        l->col_sign = -1;
    first = col_direction(l, g, 0);
    last = col_direction(l, g, n - 1);
    begin =
        g->wrap ? bisector(last, first) : mirror(bisector(first, col_direction(l, g, 1)), first);
    l->turn0 = quadrants(begin.x, begin.y);
    for (uint32_t k = 1; k < n; k++) {
        struct vec2 before = col_direction(l, g, k - 1), after = col_direction(l, g, k);
        struct vec2 mid = bisector(before, after);

        if (!follows(before, after))
            return -EINVAL;
        edge[k] = turned(l, mid.x, mid.y);
    }
    end = mirror(bisector(col_direction(l, g, n - 2), last), last);
    edge[0] = 0;
    edge[n] = g->wrap ? 4 : turned(l, end.x, end.y);
    if (edge[n] <= edge[n - 1]) /* a whole turn, though the seam stays open */
        edge[n] = 4;
    return 0;
}

static struct vec2 row_direction(const struct dx_lookup *l, const struct dx_geometry *g, uint32_t k)
{
    const float *d = g->table + 2 * (size_t)g->width + 6 * (size_t)k;

    return unit((double)d[0], l->row_sign * (double)d[2]);
}

static int spinning_rows(struct dx_lookup *l, const struct dx_geometry *g)
{
    const float *d = g->table + 2 * (size_t)g->width;
    double *edge = l->row.edge;
    uint32_t n = g->height;
    struct vec2 outer;

    for (uint32_t k = 0; k < n; k++, d += 6)
        if (d[1] != 0 || d[3] != 0 || d[4] != 0 || d[5] != 0 || !(d[0] > -1e-6f))
            return -EINVAL;
    l->row_sign = 1;
    if (cross(row_direction(l, g, 0), row_direction(l, g, 1)) < 0)
        l->row_sign = -1;
    for (uint32_t k = 1; k < n; k++)
        edge[k] = bisector(row_direction(l, g, k - 1), row_direction(l, g, k)).y;
    outer =
        mirror(bisector(row_direction(l, g, 0), row_direction(l, g, 1)), row_direction(l, g, 0));
    edge[0] = outer.x > 0 ? outer.y : -PAST_POLE;
    outer = mirror(bisector(row_direction(l, g, n - 2), row_direction(l, g, n - 1)),
                   row_direction(l, g, n - 1));
    edge[n] = outer.x > 0 ? outer.y : PAST_POLE;
    return 0;
}

/* ---- pinhole -------------------------------------------------------------------------------- */

static void tangents(struct dx_lookup_axis *a, double *sign, const float *table)
{
    double *edge = a->edge;
    uint32_t n = a->n;

    *sign = table[0] < table[1] ? 1 : -1;
    for (uint32_t k = 1; k < n; k++)
        edge[k] = *sign * ((double)table[k - 1] + (double)table[k]) / 2;
    edge[0] = 2 * *sign * (double)table[0] - edge[1];
    edge[n] = 2 * *sign * (double)table[n - 1] - edge[n - 1];
}

/* ---- all ------------------------------------------------------------------------------------ */

static int fill(struct dx_lookup *l, const struct dx_geometry *g)
{
    int rc;

    if (g->model == DX_MODEL_PINHOLE) {
        tangents(&l->col, &l->col_sign, g->table);
        tangents(&l->row, &l->row_sign, g->table + g->width);
        return 0;
    }
    rc = spinning_columns(l, g);
    return rc ? rc : spinning_rows(l, g);
}

int dx_lookup_init(struct dx_lookup *l, const struct dx_geometry *g)
{
    int rc;

    *l = (struct dx_lookup){.model = g->model};
    if (g->model == DX_MODEL_TABLE || g->height < 2 || g->width < 2)
        return -EINVAL;
    rc = axis_init(&l->col, g->width);
    if (rc == 0)
        rc = axis_init(&l->row, g->height);
    if (rc == 0)
        rc = fill(l, g);
    if (rc == 0)
        rc = axis_complete(&l->col);
    if (rc == 0)
        rc = axis_complete(&l->row);
    if (rc)
        dx_lookup_fini(l);
    return rc;
}

void dx_lookup_fini(struct dx_lookup *l)
{
    free(l->col.edge);
    free(l->col.first);
    free(l->row.edge);
    free(l->row.first);
    *l = (struct dx_lookup){0};
}

bool dx_lookup_find(const struct dx_lookup *l, const double p[3], double r, uint32_t *row,
                    uint32_t *col)
{
    if (l->model == DX_MODEL_PINHOLE) {
        if (!(p[2] > 0))
            return false;
        *col = axis_find(&l->col, l->col_sign * p[0] / p[2]);
        *row = axis_find(&l->row, l->row_sign * p[1] / p[2]);
    } else {
        *col = axis_find(&l->col, turned(l, p[0], l->col_sign * p[1]));
        *row = axis_find(&l->row, l->row_sign * p[2] / r);
    }
    return *col < l->col.n && *row < l->row.n;
}
