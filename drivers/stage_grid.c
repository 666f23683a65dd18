/* Rows, columns and geometry of a scanner on a stage. */
#include "drivers/stage_grid.h"

#include "core/base/trig.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define UNIT_M     0.001
#define GAP_ROWS   3    /* more than a surface is continued over */
#define MIN_UPWARD 0.05 /* sine of a scan plane's tilt; below it the plane is level */
#define ON_AXIS    1e-6 /* metres, and steps: what counts as none */
#define MARGIN     0.98 /* columns for each scan: a little wider than the scans lie apart */

/* A value's place on the circle of the scan: `beta` from the zenith, on the front or the back. */
struct place {
    double beta; /* 0 zenith, pi nadir */
    bool back, pole;
};

struct mount {
    double r[9];            /* scanner to stage */
    double zenith;          /* the scanner's angle that looks up most */
    double upward;          /* the sine of how far up that is */
    bool forward_is_behind; /* the scanner's angle 0 lies past the zenith */
};

static void mount_init(struct mount *m, const double deg[3])
{
    double sr, cr, sp, cp, sy, cy;

    dx_sincos(dx_rad(deg[0]), &sr, &cr);
    dx_sincos(dx_rad(deg[1]), &sp, &cp);
    dx_sincos(dx_rad(deg[2]), &sy, &cy);
    const double pitched[9] = {cp, -sp * sr, -sp * cr, 0, cr, -sr, sp, cp * sr, cp * cr};

    for (int k = 0; k < 3; k++) {
        m->r[k] = cy * pitched[k] - sy * pitched[3 + k];
        m->r[3 + k] = sy * pitched[k] + cy * pitched[3 + k];
        m->r[6 + k] = pitched[6 + k];
    }
    m->zenith = dx_atan2(m->r[8], m->r[6]);
    m->upward = sqrt(m->r[6] * m->r[6] + m->r[8] * m->r[8]);
    m->forward_is_behind = m->zenith < -ON_AXIS;
}

static void look(double d[3], const struct mount *m, double angle)
{
    double s, c;

    dx_sincos(angle, &s, &c);
    for (int k = 0; k < 3; k++)
        d[k] = m->r[3 * k] * c + m->r[3 * k + 2] * s;
}

static struct place place_of(const struct mount *m, const struct dx_line_shape *shape, uint32_t i)
{
    double beta = shape->angle0_rad + i * shape->step_rad - m->zenith;
    struct place p;

    while (beta > DX_PI)
        beta -= 2 * DX_PI;
    while (beta <= -DX_PI)
        beta += 2 * DX_PI;
    p.back = m->forward_is_behind ? beta < 0 : beta > 0;
    p.beta = fabs(beta);
    /* every column meets at the poles: no dexels there */
    p.pole = p.beta < shape->step_rad * 1e-3 || p.beta > DX_PI - shape->step_rad * 1e-3;
    return p;
}

/* Where the values of each half lie: least and largest angle from the zenith. */
struct extent {
    double min[2], max[2];
    uint32_t n[2];
};

static struct extent extent_of(const struct mount *m, const struct dx_line_shape *shape)
{
    struct extent e = {.min = {INFINITY, INFINITY}};

    for (uint32_t i = 0; i < shape->n; i++) {
        struct place p = place_of(m, shape, i);

        if (p.pole)
            continue;
        e.n[p.back]++;
        e.min[p.back] = p.beta < e.min[p.back] ? p.beta : e.min[p.back];
        e.max[p.back] = p.beta > e.max[p.back] ? p.beta : e.max[p.back];
    }
    return e;
}

/* Whether both halves can lie in the same rows and columns, exactly. */
static bool is_on_axis(const struct dx_stage_config *c, const struct mount *m,
                       const struct extent *e, double step)
{
    double apart = (e->min[1] - e->min[0]) / step;

    return fabs(c->offset_m[0]) < ON_AXIS && fabs(c->offset_m[1]) < ON_AXIS &&
           m->upward > 1 - 1e-9 && fabs(apart - rint(apart)) < 1e-3;
}

static enum dx_stage_layout choose_layout(const struct dx_stage_config *c, const struct mount *m,
                                          const struct extent *e, double step)
{
    bool turns_half = c->sweep == DX_STAGE_HALF ||
                      (c->sweep == DX_STAGE_SWING && c->angle.swing_deg <= 180 + 1e-9);
    bool front_sees_all = e->max[0] >= e->max[1] - step && e->min[0] <= e->min[1] + step;

    if (c->halves == DX_STAGE_HALVES_FRONT || e->n[1] == 0 ||
        (c->halves == DX_STAGE_HALVES_AUTO && !turns_half && front_sees_all))
        return DX_STAGE_FRONT;
    return turns_half && (c->exact || is_on_axis(c, m, e, step)) ? DX_STAGE_JOINED
                                                                 : DX_STAGE_LAYERS;
}

/* ---- columns ----------------------------------------------------------------------------------
 */

uint32_t dx_stage_grid_turn(const struct dx_stage_config *c, const struct dx_line_shape *shape)
{
    double turn = c->columns;

    if (turn == 0) {
        double most =
            4 * DX_PI / shape->step_rad; /* half a step of the scanner: finer says nothing */

        turn = c->angle.rpm > 0 ? floor(MARGIN * shape->lines_s * 60 / c->angle.rpm) : most / 2;
        turn = turn > most ? most : turn;
    }
    turn = turn < 8 ? 8 : turn > DX_PLANE_MAX_SIDE - 1 ? DX_PLANE_MAX_SIDE - 1 : turn;
    return (uint32_t)turn & ~1u;
}

static void lay_columns(struct dx_stage_grid *g, const struct dx_stage_config *c,
                        const struct dx_line_shape *shape)
{
    double swing = dx_rad(c->angle.swing_deg);

    g->turn = dx_stage_grid_turn(c, shape);
    g->columns_rad = g->turn / (2 * DX_PI);
    g->low_rad = 0;
    g->sweep = c->sweep == DX_STAGE_FULL ? g->turn : g->turn / 2;
    if (c->sweep == DX_STAGE_SWING) {
        g->sweep = (uint32_t)ceil(swing * g->columns_rad - 1e-6);
        g->sweep = g->sweep < 2 ? 2 : g->sweep;
        g->low_rad = dx_rad(c->angle.start_deg) - (c->angle.clockwise ? swing : 0);
    }
    g->width = c->sweep == DX_STAGE_SWING && g->layout != DX_STAGE_JOINED ? g->sweep : g->turn;
}

static void fill_columns(const struct dx_stage_grid *g)
{
    for (uint32_t j = 0; j < g->width; j++) {
        double s, c;

        dx_sincos(g->low_rad + (j + 0.5) / g->columns_rad, &s, &c);
        g->geometry->table[2 * j] = (float)c;
        g->geometry->table[2 * j + 1] = (float)s;
    }
}

/* ---- rows -------------------------------------------------------------------------------------
 */

static uint32_t steps_between(double from, double to, double step)
{
    return (uint32_t)rint((to - from) / step);
}

/* Numbers the rows, each half from its lowest value up to the zenith; returns how many there are.
 */
static uint32_t lay_rows(struct dx_stage_grid *g, const struct mount *m,
                         const struct dx_line_shape *shape, const struct extent *e)
{
    double step = shape->step_rad, max[2] = {e->max[0], e->max[1]};
    uint32_t base[2] = {0, 0},
             n_front = e->n[0] ? steps_between(e->min[0], e->max[0], step) + 1 : 0;
    uint32_t n_rows = 0;

    if (g->layout == DX_STAGE_JOINED)
        max[0] = max[1] = max[0] > max[1] ? max[0] : max[1];
    else if (g->layout == DX_STAGE_LAYERS)
        base[1] = n_front + (n_front ? GAP_ROWS : 0);
    for (uint32_t i = 0; i < shape->n; i++) {
        struct place p = place_of(m, shape, i);

        look(g->dir + 3 * i, m, shape->angle0_rad + i * step);
        g->back[i] = p.back;
        g->row[i] = DX_STAGE_NO_ROW;
        if (p.pole || (p.back && g->layout == DX_STAGE_FRONT))
            continue;
        g->row[i] = base[p.back] + steps_between(p.beta, max[p.back], step);
        n_rows = g->row[i] + 1 > n_rows ? g->row[i] + 1 : n_rows;
    }
    return n_rows;
}

static void fill_rows(const struct dx_stage_grid *g)
{
    float *rows = g->geometry->table + 2 * (size_t)g->width;
    bool joined = g->layout == DX_STAGE_JOINED;

    for (uint32_t r = 0; r < g->geometry->height; r++) /* rows without values look ahead */
        rows[6 * (size_t)r] = 1;
    for (int back = 1; back >= 0; back--) /* the front's own where both have the row */
        for (uint32_t i = 0; i < g->n; i++) {
            float *row = rows + 6 * (size_t)g->row[i];
            double turn = joined && back ? -1 : 1; /* half a turn */

            if (g->row[i] == DX_STAGE_NO_ROW || g->back[i] != (back == 1))
                continue;
            row[0] = (float)(turn * g->dir[3 * i]);
            row[1] = (float)(turn * g->dir[3 * i + 1]);
            row[2] = (float)g->dir[3 * i + 2];
            row[3] = joined ? 0 : (float)g->origin[0];
            row[4] = joined ? 0 : (float)g->origin[1];
            row[5] = (float)g->origin[2];
        }
}

/* ---- the grid ---------------------------------------------------------------------------------
 */

static int allocate(struct dx_stage_grid *g, uint32_t n)
{
    g->n = n;
    g->row = calloc(n, sizeof(*g->row));
    g->back = calloc(n, sizeof(*g->back));
    g->dir = calloc(n, 3 * sizeof(*g->dir));
    return g->row && g->back && g->dir ? 0 : -ENOMEM;
}

static int make_geometry(struct dx_stage_grid *g, const struct dx_stage_config *c, double max_m,
                         uint32_t height, struct dx_err *err)
{
    double away = sqrt(g->origin[0] * g->origin[0] + g->origin[1] * g->origin[1]);
    int r =
        height < 2 ? -EINVAL : dx_geometry_new(&g->geometry, DX_MODEL_SPINNING, height, g->width);

    if (r)
        return dx_err_set(err, r, "stage: a grid of %u rows and %u columns%s", height, g->width,
                          r == -ENOMEM ? ": no memory" : " is not possible");
    g->geometry->unit_m = (float)UNIT_M;
    g->geometry->range_bytes = max_m + away > 65.535 ? 4 : 2;
    g->geometry->exact = c->exact;
    g->geometry->wrap = g->width == g->turn;
    fill_columns(g);
    fill_rows(g);
    dx_geometry_orient(g->geometry);
    return 0;
}

const char *dx_stage_grid_check(const double angles_deg[3])
{
    struct mount m;

    mount_init(&m, angles_deg);
    return m.upward < MIN_UPWARD
               ? "angles lay the scan plane level, so that turning it sweeps nothing"
               : NULL;
}

int dx_stage_grid_init(struct dx_stage_grid *g, const struct dx_stage_config *config,
                       const struct dx_line_shape *shape, struct dx_err *err)
{
    const char *why = dx_stage_grid_check(config->angles_deg);
    struct extent e;
    struct mount m;
    int r;

    *g = (struct dx_stage_grid){.width = 0};
    mount_init(&m, config->angles_deg);
    if (why)
        return dx_err_set(err, -EINVAL, "stage: %s", why);
    r = allocate(g, shape->n);
    if (r) {
        dx_stage_grid_fini(g);
        return dx_err_set(err, r, "stage: no memory");
    }
    memcpy(g->origin, config->offset_m, sizeof(g->origin));
    e = extent_of(&m, shape);
    g->layout = choose_layout(config, &m, &e, shape->step_rad);
    lay_columns(g, config, shape);
    r = make_geometry(g, config, shape->max_m, lay_rows(g, &m, shape, &e), err);
    if (r)
        dx_stage_grid_fini(g);
    return r;
}

void dx_stage_grid_fini(struct dx_stage_grid *g)
{
    dx_geometry_unref(g->geometry);
    free(g->row);
    free(g->back);
    free(g->dir);
    *g = (struct dx_stage_grid){.width = 0};
}
