/*
 * Scans to columns. A column's number counts on over turns; a frame is those of one sweep. The
 * stage moves one way within a frame, so what it has left is delivered and never touched again: a
 * stage that turns back ends the frame.
 */
#include "drivers/stage.h"

#include "core/base/trig.h"
#include "drivers/stage_grid.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Columns that a stage may go back before it counts as turned back: what an encoder trembles. */
#define TREMBLE_SWING 0.5
#define TREMBLE_TURN  16 /* a share of a sweep: of a stage that is not meant to turn back */

/* Values of a dexel are averaged while they agree to that. */
#define AGREE_MM    30
#define AGREE_SHARE 0.01

struct cell { /* of a dexel whose mean is taken */
    uint32_t sum;
    uint16_t n;
};

struct dx_turning_stage {
    struct dx_stage_config config;
    struct dx_line_shape shape;
    struct dx_stage_grid grid;
    bool has_grid;
    struct dx_err refused; /* "": not; else why `shape` has no grid */
    struct cell *cells;    /* NULL: the last value counts */
    struct dx_stage_counts counts;

    uint64_t next_frame;
    bool open; /* a frame is being filled */
    uint64_t frame;
    int dir;             /* +1, -1; 0: not known yet */
    int64_t sweep;       /* its number */
    int64_t column;      /* where the stage is */
    int64_t undelivered; /* the first column, in its direction, that was not delivered */
    double far;          /* how far the stage has come, in columns */
    bool outside;        /* of the swing, or of the frame's sweep: nothing is written */

    /* within dx_stage_put() */
    const struct dx_frame_sink *sink;
    const struct dx_line *line;
    struct dx_plane *plane;
    bool ended; /* a frame, in this scan */
};

const char *dx_stage_check(const struct dx_stage_config *c, const char **key)
{
    const char *why;

    *key = "stage.exact";
    if (c->exact && c->mean)
        return "exact points need the last of several values, found their mean";
    *key = "stage.sweep";
    if (c->sweep == DX_STAGE_SWING && !(c->angle.swing_deg > 0))
        return "sweeps back and forth need a swing";
    *key = "stage.swing";
    if (c->sweep != DX_STAGE_SWING && c->angle.swing_deg > 0)
        return "a swing needs sweeps back and forth";
    *key = "stage.columns";
    if (c->columns == 1 || c->columns % 2)
        return "expected an even number of columns, so that half a turn is a whole number";
    *key = "stage.angles";
    why = dx_stage_grid_check(c->angles_deg);
    return why ? why : dx_angle_check(&c->angle, key);
}

double dx_stage_stride(const struct dx_stage_config *config, const struct dx_line_shape *shape,
                       double rad_s, uint32_t *turn)
{
    *turn = dx_stage_grid_turn(config, shape);
    return fabs(rad_s) / (2 * DX_PI) * *turn / shape->lines_s;
}

int dx_stage_new(struct dx_turning_stage **out, const struct dx_stage_config *config,
                 struct dx_err *err)
{
    const char *key, *why = dx_stage_check(config, &key);
    struct dx_turning_stage *st;

    if (why)
        return dx_err_set(err, -EINVAL, "stage: %s", why);
    st = calloc(1, sizeof(*st));
    if (!st)
        return dx_err_set(err, -ENOMEM, "stage: no memory");
    st->config = *config;
    *out = st;
    return 0;
}

void dx_stage_free(struct dx_turning_stage *st)
{
    if (!st)
        return;
    dx_stage_grid_fini(&st->grid);
    free(st->cells);
    free(st);
}

void dx_stage_restart(struct dx_turning_stage *st)
{
    st->open = false;
    st->dir = 0;
}

static bool is_same_shape(const struct dx_line_shape *a, const struct dx_line_shape *b)
{
    return a->n == b->n && a->angle0_rad == b->angle0_rad && a->step_rad == b->step_rad &&
           a->max_m == b->max_m && a->lines_s == b->lines_s && a->attr_bytes == b->attr_bytes;
}

int dx_stage_shape(struct dx_turning_stage *st, const struct dx_line_shape *shape,
                   const struct dx_frame_sink *sink, struct dx_err *err)
{
    int r;

    if (st->has_grid && is_same_shape(&st->shape, shape))
        return 0;
    if (*st->refused.text && is_same_shape(&st->shape, shape))
        return dx_err_set(err, -EINVAL, "%s", st->refused.text);
    dx_stage_grid_fini(&st->grid);
    free(st->cells);
    st->cells = NULL;
    st->has_grid = false;
    dx_stage_restart(st);
    st->refused.text[0] = 0;
    r = dx_stage_grid_init(&st->grid, &st->config, shape, err);
    if (r == -EINVAL) { /* each scan would try it anew */
        st->refused = *err;
        st->shape = *shape;
    }
    if (r)
        return r;
    if (st->config.mean) {
        st->cells = calloc((size_t)st->grid.geometry->height * st->grid.width, sizeof(*st->cells));
        if (!st->cells)
            return dx_err_set(err, -ENOMEM, "stage: no memory");
    }
    r = sink->geometry(sink->ctx, st->grid.geometry, shape->attr_bytes);
    if (r)
        return r;
    st->shape = *shape;
    st->has_grid = true;
    return 0;
}

/* ---- delivering -------------------------------------------------------------------------------
 */

static int64_t floor_div(int64_t a, int64_t b)
{
    return a / b - (a % b < 0);
}

/* The geometry's column of the stage's. */
static uint32_t place(const struct dx_turning_stage *st, int64_t column, bool half_turn)
{
    int64_t turn = st->grid.turn, j = column + (half_turn ? turn / 2 : 0);

    return (uint32_t)(j - floor_div(j, turn) * turn);
}

/* Columns from one of the stage's to another, both included, in either order. */
static void deliver(struct dx_turning_stage *st, int64_t from, int64_t to, bool last)
{
    int64_t low = from < to ? from : to, high = from < to ? to : from;
    bool joined = st->grid.layout == DX_STAGE_JOINED;
    struct dx_frame_part part = {.frame = st->frame,
                                 .col0 = place(st, low, false),
                                 .n_cols = (uint32_t)(high - low + 1),
                                 .last = last && !joined,
                                 .stamp = st->line->stamp};

    st->sink->deliver(st->sink->ctx, &part);
    if (!joined)
        return;
    part.col0 = place(st, low, true);
    part.last = last;
    st->sink->deliver(st->sink->ctx, &part);
}

/* Those that the stage has left. */
static void deliver_passed(struct dx_turning_stage *st)
{
    int64_t until = st->column - st->dir;

    if (st->dir == 0 || (until - st->undelivered) * st->dir < 0)
        return;
    deliver(st, st->undelivered, until, false);
    st->undelivered = st->column;
}

/* The first and the last column of the sweep in the stage's direction. */
static int64_t edge(const struct dx_turning_stage *st, int64_t sweep, bool far)
{
    int64_t low = st->config.sweep == DX_STAGE_SWING ? 0 : sweep * st->grid.sweep;

    return far == (st->dir >= 0) ? low + st->grid.sweep - 1 : low;
}

/* `crossed`: the stage has gone on over the sweep's end, so what it jumped over stays empty. */
static void end_frame(struct dx_turning_stage *st, bool crossed)
{
    deliver(st, st->undelivered, crossed ? edge(st, st->sweep, true) : (int64_t)floor(st->far),
            true);
    st->open = false;
    st->ended = true;
}

/* ---- moving -----------------------------------------------------------------------------------
 */

static int begin_frame(struct dx_turning_stage *st, int64_t sweep, double at, bool crossed)
{
    st->frame = st->next_frame;
    st->plane = st->sink->plane(st->sink->ctx, st->frame);
    if (!st->plane)
        return DX_DRIVER_E_AGAIN;
    st->next_frame++;
    st->open = true;
    st->sweep = sweep;
    st->column = (int64_t)floor(at);
    st->undelivered = crossed ? edge(st, sweep, false) : st->column;
    st->far = at;
    if (st->cells)
        memset(st->cells, 0,
               (size_t)st->grid.geometry->height * st->grid.width * sizeof(*st->cells));
    return 0;
}

static bool has_turned_back(const struct dx_turning_stage *st, double at)
{
    double tremble =
        st->config.sweep == DX_STAGE_SWING ? TREMBLE_SWING : (double)st->grid.sweep / TREMBLE_TURN;

    return st->dir != 0 && (st->far - at) * st->dir > tremble;
}

/* What lies beyond the ends of the swing counts as its ends. */
static double within_swing(struct dx_turning_stage *st, double at)
{
    double end = st->grid.sweep - 1e-6;

    st->outside = false;
    if (st->config.sweep != DX_STAGE_SWING)
        return at;
    st->outside = at < -TREMBLE_SWING || at > end + TREMBLE_SWING;
    return at < 0 ? 0 : at > end ? end : at;
}

/* The stage is at `at` now. */
static int move_to(struct dx_turning_stage *st, double at)
{
    int64_t column, sweep;
    bool crossed = false;

    at = within_swing(st, at);
    column = (int64_t)floor(at);
    sweep = st->config.sweep == DX_STAGE_SWING ? 0 : floor_div(column, st->grid.sweep);

    if (st->open && st->dir != 0 && sweep == st->sweep - st->dir && !has_turned_back(st, at)) {
        st->outside = true; /* it trembles over the sweep's beginning */
        return 0;
    }
    if (st->open && sweep != st->sweep) {
        crossed = st->dir != 0 && sweep == st->sweep + st->dir;
        if (st->dir == 0)
            st->dir = sweep > st->sweep ? 1 : -1;
        end_frame(st, crossed);
    } else if (st->open && has_turned_back(st, at)) {
        end_frame(st, false);
        st->dir = -st->dir;
    }
    if (!st->open)
        return begin_frame(st, sweep, at, crossed);
    if (st->dir == 0 && column != st->column)
        st->dir = column > st->column ? 1 : -1;
    if (st->dir == 0 || (at - st->far) * st->dir > 0)
        st->far = at;
    st->column = column;
    return 0;
}

/* ---- writing ----------------------------------------------------------------------------------
 */

static void write_point(struct dx_turning_stage *st, uint32_t i, size_t k, double angle,
                        double range_m)
{
    const struct dx_stage_grid *g = &st->grid;
    const double *d = g->dir + 3 * (size_t)i;
    double p[3], s, c, x, y;

    for (int m = 0; m < 3; m++)
        p[m] = g->origin[m] + range_m * d[m];
    dx_sincos(angle, &s, &c);
    x = p[0] * c - p[1] * s;
    y = p[0] * s + p[1] * c;
    p[2] -= g->origin[2];
    /* from the axis: the same for both halves, whatever the mount */
    dx_plane_set_range(st->plane, k,
                       dx_geometry_units(g->geometry, sqrt(x * x + y * y + p[2] * p[2])));
    st->plane->xyz[3 * k] = (float)x;
    st->plane->xyz[3 * k + 1] = (float)y;
    st->plane->xyz[3 * k + 2] = (float)(p[2] + g->origin[2]);
    if (!dx_plane_range(st->plane, k))
        memset(st->plane->xyz + 3 * k, 0, 3 * sizeof(float));
}

static uint32_t mean_with(struct cell *c, uint32_t mm)
{
    double mean = c->n ? (double)c->sum / c->n : mm;

    if (fabs(mean - mm) > AGREE_MM + AGREE_SHARE * mean || c->n == UINT16_MAX ||
        mm > UINT32_MAX - c->sum)
        *c = (struct cell){0, 0}; /* another surface: it is the newer */
    c->sum += mm;
    c->n++;
    return (c->sum + c->n / 2) / c->n;
}

/* Whether the stage's column still takes values. */
static bool takes_values(struct dx_turning_stage *st)
{
    if (st->outside) {
        st->counts.n_outside++;
        return false;
    }
    if ((st->column - st->undelivered) * st->dir < 0) {
        st->counts.n_late++;
        return false;
    }
    return true;
}

static void write_value(struct dx_turning_stage *st, uint32_t i, double angle)
{
    const struct dx_stage_grid *g = &st->grid;
    uint32_t mm = st->line->range[i], col;
    size_t k;

    if (g->row[i] == DX_STAGE_NO_ROW || mm == 0 || !takes_values(st))
        return;
    col = place(st, st->column, g->back[i] && g->layout == DX_STAGE_JOINED);
    k = (size_t)g->row[i] * g->width + col;
    if (st->plane->xyz)
        write_point(st, i, k, angle, mm * 0.001);
    else
        dx_plane_set_range(st->plane, k, st->cells ? mean_with(&st->cells[k], mm) : mm);
    if (st->line->attr)
        dx_plane_set_attr(st->plane, k, st->line->attr[i]);
}

/* ---- a scan -----------------------------------------------------------------------------------
 */

/* The angle at times that ascend: even between samples, and beyond them as between the nearest. */
struct walk {
    const struct dx_angle_sample *a;
    size_t n, at;
};

static bool angle_at(struct walk *w, double t_ns, double *angle)
{
    const struct dx_angle_sample *a, *b;
    double share;

    while (w->at + 2 < w->n && t_ns >= (double)(w->a[w->at + 1].host_ns - w->a[0].host_ns))
        w->at++;
    a = &w->a[w->at];
    b = &w->a[w->at + (w->n > 1)];
    share = b == a ? 0
                   : (t_ns - (double)(a->host_ns - w->a[0].host_ns)) /
                         (double)(b->host_ns - a->host_ns);
    *angle = a->angle_rad + share * (b->angle_rad - a->angle_rad);
    return !a->uncertain && !b->uncertain && fabs(*angle) < 1e9;
}

static int put_values(struct dx_turning_stage *st, const struct dx_line *line)
{
    struct walk w = {line->angle, line->n_angles, 0};
    double t0 = (double)((int64_t)(line->host_ns - w.a[0].host_ns)), angle, first = 0, last = 0;
    struct walk end = w;

    angle_at(&w, t0, &first);
    angle_at(&end, t0 + st->grid.n * line->step_ns, &last);
    if (!(fabs(last - first) < 2 * DX_PI)) { /* no stage turns so fast */
        st->counts.n_uncertain += st->grid.n;
        return 0;
    }
    for (uint32_t i = 0; i < st->grid.n; i++) {
        int r;

        if (!angle_at(&w, t0 + i * line->step_ns, &angle)) {
            st->counts.n_uncertain++;
            continue;
        }
        r = move_to(st, (angle - st->grid.low_rad) * st->grid.columns_rad);
        if (r)
            return r;
        write_value(st, i, angle);
    }
    return 0;
}

int dx_stage_put(struct dx_turning_stage *st, const struct dx_line *line,
                 const struct dx_frame_sink *sink)
{
    int r;

    if (!st->has_grid || line->n_angles == 0) {
        st->counts.n_uncertain += st->grid.n;
        return 0;
    }
    st->sink = sink;
    st->line = line;
    if (st->open) {
        st->plane = sink->plane(sink->ctx, st->frame);
        if (!st->plane)
            return DX_DRIVER_E_AGAIN;
    }
    st->ended = false;
    r = put_values(st, line);
    /* a scan that ends a frame tells nothing of the next, or there would be no place between the
     * frames where a recording can begin */
    if (r == 0 && st->open && !st->ended)
        deliver_passed(st);
    return r;
}

const struct dx_geometry *dx_stage_geometry(const struct dx_turning_stage *st)
{
    return st->has_grid ? st->grid.geometry : NULL;
}

const char *dx_stage_layout_text(const struct dx_turning_stage *st)
{
    static const char *const text[] = {"front half", "both halves in layers", "both halves joined"};

    return text[st->grid.layout];
}

struct dx_stage_counts dx_stage_counts(const struct dx_turning_stage *st)
{
    return st->counts;
}
