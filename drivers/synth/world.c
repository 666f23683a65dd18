/* Scene tables. Spinning scanners stand at the origin, x ahead, z up; the pinhole has x right, y
 * down, z ahead. */
#include "drivers/synth/world.h"

#include "core/base/trig.h"

#include <math.h>

#define MOVING_PERIOD 120 /* frames */
#define N_POLES       24

#define ROOM(x0, y0, z0, x1, y1, z1)                                                               \
    {                                                                                              \
        .kind = DX_SHAPE_ROOM, .a = {x0, y0, z0}, .b = {x1, y1, z1}, .paint = DX_PAINT_ROOM        \
    }
#define BOX(x0, y0, z0, x1, y1, z1, grey)                                                          \
    {                                                                                              \
        .kind = DX_SHAPE_BOX, .a = {x0, y0, z0}, .b = {x1, y1, z1}, .albedo = (grey)               \
    }
#define SPHERE(x, y, z, r, grey)                                                                   \
    {                                                                                              \
        .kind = DX_SHAPE_SPHERE, .a = {x, y, z}, .b = {r}, .albedo = (grey)                        \
    }

/* Six boxes and four spheres, the same in the hall and in the open. */
#define OBJECTS                                                                                    \
    BOX(2.5, -1.0, -1.5, 3.5, 0.5, -0.3, 0.90), BOX(4.5, 2.0, -1.5, 5.5, 3.2, 0.8, 0.40),          \
        BOX(-4.0, 1.5, -1.5, -2.8, 3.0, -0.7, 0.70), BOX(-6.5, -4.5, -1.5, -5.0, -3.0, 0.4, 0.55), \
        BOX(-1.2, -4.2, -1.5, 0.6, -3.4, -0.5, 0.30), BOX(0.2, 3.6, -0.6, 1.8, 4.4, 0.3, 0.80),    \
        SPHERE(1.8, 1.9, -0.9, 0.6, 0.85), SPHERE(-2.2, -2.0, -1.0, 0.5, 0.50),                    \
        SPHERE(4.2, -3.5, -0.2, 0.9, 0.35), SPHERE(-6.0, 2.4, 0.6, 0.7, 0.95)

static const struct dx_shape hall[] = {ROOM(-9, -6, -1.5, 7, 5, 2), OBJECTS};
static const struct dx_shape open_ground[] = {ROOM(-60, -50, -1.5, 55, 45, 12), OBJECTS};

static const struct dx_shape sphere[] = {
    {.kind = DX_SHAPE_BUBBLE, .a = {0.8, -0.5, 0.4}, .b = {5}, .albedo = 0.8}};

/* Eight steps of 30 x 18 cm, all below the scanner's eye. */
#define STEP(k)                                                                                    \
    BOX(2 + 0.3 * (k), -2.0, -1.5, 5.5, 2.0, -1.5 + 0.18 * ((k) + 1), 0.5 + 0.3 * ((k) % 2))
static const struct dx_shape stairs[] = {ROOM(-3, -4, -1.5, 7, 4, 3),
                                         STEP(0),
                                         STEP(1),
                                         STEP(2),
                                         STEP(3),
                                         STEP(4),
                                         STEP(5),
                                         STEP(6),
                                         STEP(7)};

/* Poles and pickets depend on the angular step: dx_world_init adds them. */
static const struct dx_shape yard[] = {ROOM(-2, -9, -1.5, 8, 9, 4)};

/* Normals (cos 35, +-sin 35 cos 17, -+sin 35 sin 17): the planes meet 4 m ahead, on a line that
 * leans 17 degrees. */
#define CREASE_X 0.8191520442889918
#define CREASE_Y 0.54851387399083462
#define CREASE_Z 0.16769752048474765
static const struct dx_shape crease[] = {
    {.kind = DX_SHAPE_PLANE,
     .a = {CREASE_X, CREASE_Y, -CREASE_Z},
     .b = {4 * CREASE_X},
     .albedo = 0.8},
    {.kind = DX_SHAPE_PLANE,
     .a = {CREASE_X, -CREASE_Y, CREASE_Z},
     .b = {4 * CREASE_X},
     .albedo = 0.5},
};

static const struct dx_shape camera_room[] = {
    ROOM(-2.6, -1.6, -1, 2.8, 1.3, 5),        BOX(-2.4, 0.3, 3.4, -1.2, 1.3, 4.2, 0.40),
    BOX(0.9, -0.2, 3.9, 1.9, 1.3, 4.8, 0.75), SPHERE(-0.2, 0.9, 3.6, 0.4, 0.90),
    SPHERE(1.5, -0.9, 4.2, 0.35, 0.60),
};

#define SHAPES(table) .shape = (table), .n_shapes = sizeof(table) / sizeof((table)[0])

const struct dx_world_spec dx_world_specs[DX_N_SCENES] = {
    [DX_SCENE_HALL] = {"hall",
                       "room of 16 x 11 x 3.5 m, six boxes, four spheres; full turn",
                       400,
                       600,
                       {{0, 360}, {-65, 65}, 0},
                       12,
                       SHAPES(hall)},
    [DX_SCENE_OPEN] = {"open",
                       "open ground, walls 45 to 60 m away, the hall's objects; full turn",
                       400,
                       600,
                       {{0, 360}, {-65, 65}, 0},
                       80,
                       SHAPES(open_ground)},
    [DX_SCENE_SPHERE] = {"sphere",
                         "sphere of 5 m from inside, off its centre; full turn, pole to pole",
                         400,
                         600,
                         {{0, 360}, {-90, 90}, 0},
                         7,
                         SHAPES(sphere)},
    [DX_SCENE_STAIRS] = {"stairs",
                         "eight steps of 30 x 18 cm in a room",
                         400,
                         600,
                         {{-45, 45}, {-40, 20}, 0},
                         9,
                         SHAPES(stairs)},
    [DX_SCENE_POLES] = {"poles",
                        "poles one to three dexels wide before a wall",
                        400,
                        600,
                        {{-60, 60}, {-30, 30}, 0},
                        14,
                        SHAPES(yard)},
    [DX_SCENE_FENCE] = {"fence",
                        "a picket in every second column, 3 m away, before a wall",
                        400,
                        600,
                        {{-60, 60}, {-30, 30}, 0},
                        14,
                        SHAPES(yard)},
    [DX_SCENE_CREASE] = {"crease",
                         "two planes that meet on a line at 17 degrees to the grid",
                         400,
                         600,
                         {{-30, 30}, {-20, 20}, 0},
                         6,
                         SHAPES(crease)},
    [DX_SCENE_MOVING_BOX] = {"moving-box",
                             "pinhole camera: a box crosses a room, period 120 frames",
                             480,
                             640,
                             {{0, 0}, {0, 0}, 0.82},
                             6,
                             SHAPES(camera_room)},
};

static void add(struct dx_world *w, const struct dx_shape *s)
{
    w->shape[w->n] = *s;
    dx_shape_bound(&w->shape[w->n++]);
}

/* Pole k is 1 + k mod 3 columns wide: a quarter of a step from being narrower or wider. Odd ones
 * are centred on a column, even ones between two. */
static void add_poles(struct dx_world *w, const struct dx_scene_config *c,
                      const struct dx_view *view)
{
    double az0 = dx_rad(view->azimuth_deg[0]);
    double step = dx_rad(view->azimuth_deg[1] - view->azimuth_deg[0]) / c->width;

    for (uint32_t k = 0; k < N_POLES; k++) {
        uint32_t wide = 1 + k % 3;
        uint64_t col = (uint64_t)c->width * (k + 1) / (N_POLES + 1);
        double az = az0 + step * ((double)col + (wide == 2 ? 0 : 0.5));
        double away = 3 + 0.5 * (k % 4), s, cos_az;
        struct dx_shape pole = {.kind = DX_SHAPE_POLE, .albedo = 0.3 + 0.2 * (k % 4)};

        dx_sincos(az, &s, &cos_az);
        pole.a[0] = away * cos_az;
        pole.a[1] = away * s;
        pole.a[2] = -1.5;
        pole.b[0] = away * dx_sin(step * (wide - 0.5) / 2);
        pole.b[2] = 0.9;
        add(w, &pole);
    }
}

static void add_fence(struct dx_world *w, const struct dx_scene_config *c,
                      const struct dx_view *view)
{
    struct dx_shape fence = {.kind = DX_SHAPE_FENCE, .albedo = 0.9};

    fence.a[0] = dx_rad(view->azimuth_deg[0]);
    fence.a[1] = dx_rad(view->azimuth_deg[1] - view->azimuth_deg[0]) / c->width;
    fence.a[2] = -1.5;
    fence.b[0] = 3;
    fence.b[2] = 0.6;
    add(w, &fence);
}

/* An ellipse in front of everything else; the box covers about 9 % of the image's width. */
static void add_moving_box(struct dx_world *w, uint64_t number)
{
    double s, c;
    struct dx_shape box = {.kind = DX_SHAPE_BOX, .albedo = 0.95};

    dx_sincos(2 * DX_PI * (double)(number % MOVING_PERIOD) / MOVING_PERIOD, &s, &c);
    for (int k = 0; k < 3; k++) {
        double centre = k == 0 ? 1.0 * s : k == 1 ? 0.25 * c : 2.3 + 0.3 * c;

        box.a[k] = centre - 0.11;
        box.b[k] = centre + 0.11;
    }
    add(w, &box);
}

void dx_world_init(struct dx_world *w, const struct dx_scene_config *c, uint64_t number)
{
    const struct dx_world_spec *spec = &dx_world_specs[c->scene];
    bool pinhole = spec->view.focal > 0;

    w->n = 0;
    w->up = pinhole ? 1 : 2;
    w->up_sign = pinhole ? -1 : 1;
    for (unsigned k = 0; k < spec->n_shapes; k++)
        add(w, &spec->shape[k]);
    if (c->scene == DX_SCENE_POLES)
        add_poles(w, c, &spec->view);
    else if (c->scene == DX_SCENE_FENCE)
        add_fence(w, c, &spec->view);
    else if (c->scene == DX_SCENE_MOVING_BOX)
        add_moving_box(w, number);
}

bool dx_world_moves(enum dx_scene scene)
{
    return scene == DX_SCENE_MOVING_BOX;
}

/* The indices [*from, *to) of a monotone table with values in [lo, hi]. */
static void table_span(const float *table, uint32_t n, double lo, double hi, uint32_t *from,
                       uint32_t *to)
{
    *from = n;
    *to = 0;
    for (uint32_t k = 0; k < n; k++)
        if ((double)table[k] >= lo - 1e-9 && (double)table[k] <= hi + 1e-9) {
            *from = k < *from ? k : *from;
            *to = k + 1;
        }
    if (*from > *to)
        *from = *to;
}

struct dx_rect dx_world_moving_rect(const struct dx_geometry *g, const struct dx_world *w)
{
    const struct dx_shape *box = &w->shape[w->n - 1];
    struct dx_rect r;
    double lo[2], hi[2];

    /* the tangents of the box's corners are extreme at its near or its far side */
    for (int k = 0; k < 2; k++) {
        lo[k] = box->a[k] / (box->a[k] < 0 ? box->a[2] : box->b[2]);
        hi[k] = box->b[k] / (box->b[k] > 0 ? box->a[2] : box->b[2]);
    }
    table_span(g->table, g->width, lo[0], hi[0], &r.col0, &r.col1);
    table_span(g->table + g->width, g->height, lo[1], hi[1], &r.row0, &r.row1);
    return r;
}
