/* Scenes to geometries and frames, without memory between calls. */
#include "drivers/synth/scene.h"

#include "core/base/trig.h"
#include "drivers/synth/sight.h"

#include <errno.h>
#include <math.h>
#include <string.h>

#define STRIP 128 /* columns cast at a time: three rows of sights on the stack */

const char *dx_scene_name(unsigned scene)
{
    return scene < DX_N_SCENES ? dx_world_specs[scene].name : NULL;
}

const char *dx_scene_help(unsigned scene)
{
    return scene < DX_N_SCENES ? dx_world_specs[scene].help : NULL;
}

int dx_scene_from_name(const char *name)
{
    for (int k = 0; k < DX_N_SCENES; k++)
        if (strcmp(dx_world_specs[k].name, name) == 0)
            return k;
    return -1;
}

void dx_scene_config_default(struct dx_scene_config *c, enum dx_scene scene)
{
    *c = (struct dx_scene_config){
        .scene = scene,
        .height = dx_world_specs[scene].height,
        .width = dx_world_specs[scene].width,
        .seed = 1,
        .unit_m = 1e-3,
    };
}

/* Reverses n elements of `len` floats. */
static void reverse(float *table, uint32_t n, size_t len)
{
    for (uint32_t k = 0; k < n / 2; k++)
        for (size_t m = 0; m < len; m++) {
            float *a = table + k * len + m, *b = table + (n - 1 - k) * len + m, t = *a;

            *a = *b;
            *b = t;
        }
}

static void flip(struct dx_geometry *g, bool rows, bool cols)
{
    size_t col_len = g->model == DX_MODEL_PINHOLE ? 1 : 2;
    size_t row_len = g->model == DX_MODEL_PINHOLE ? 1 : 6;

    if (cols)
        reverse(g->table, g->width, col_len);
    if (rows)
        reverse(g->table + col_len * g->width, g->height, row_len);
    dx_geometry_orient(g);
}

static int new_geometry(struct dx_geometry **out, const struct dx_scene_config *c)
{
    const struct dx_view *view = &dx_world_specs[c->scene].view;
    double focal = view->focal * c->width;
    double az0 = dx_rad(view->azimuth_deg[0]), el0 = dx_rad(view->elevation_deg[0]);
    double az_step = (dx_rad(view->azimuth_deg[1]) - az0) / c->width;
    double el_step = (dx_rad(view->elevation_deg[1]) - el0) / c->height;

    if (view->focal > 0)
        return dx_geometry_new_pinhole(out, c->height, c->width, focal, focal, (c->width - 1) / 2.0,
                                       (c->height - 1) / 2.0);
    return dx_geometry_new_spinning(out, c->height, c->width, az0 + az_step / 2, az_step,
                                    el0 + el_step / 2, el_step);
}

int dx_scene_geometry(struct dx_geometry **out, const struct dx_scene_config *c)
{
    double unit_m = c->unit_m == 0 ? 1e-3 : c->unit_m;
    double reach;
    int r;

    if ((unsigned)c->scene >= DX_N_SCENES || c->height < 2 || c->width < 8 || c->attr_bytes > 2 ||
        !(unit_m >= 1e-6 && unit_m <= 1))
        return -EINVAL;
    r = new_geometry(out, c);
    if (r)
        return r;
    reach = dx_world_specs[c->scene].reach_m;
    reach += 8 * (c->sigma[0] + reach * (c->sigma[1] + reach * c->sigma[2]));
    (*out)->unit_m = (float)unit_m;
    (*out)->range_bytes = reach / unit_m > 65535 ? 4 : 2;
    flip(*out, c->flip_rows, c->flip_cols);
    return 0;
}

/* Rows of a strip: `sights` holds three in turn, so that mixing sees the rows above and below. */
static void cast_strip(struct dx_plane *plane, const struct dx_geometry *g,
                       const struct dx_world *w, const struct dx_sensor *sensor, uint32_t col0,
                       uint32_t n)
{
    struct dx_sight sights[3][STRIP + 2];
    struct dx_sight *above = NULL, *here = sights[0], *below;

    dx_sight_row(here, w, g, 0, (int64_t)col0 - 1, n + 2);
    for (uint32_t row = 0; row < g->height; row++) {
        below = row + 1 < g->height ? sights[(row + 1) % 3] : NULL;
        if (below)
            dx_sight_row(below, w, g, row + 1, (int64_t)col0 - 1, n + 2);
        dx_sensor_row(plane, sensor, row, col0, n, here + 1, above ? above + 1 : NULL,
                      below ? below + 1 : NULL);
        above = here;
        here = below;
    }
}

void dx_scene_cast(struct dx_plane *plane, const struct dx_geometry *g,
                   const struct dx_scene_config *c, uint64_t number, uint32_t col0, uint32_t n_cols)
{
    struct dx_world world;
    struct dx_sensor sensor;

    dx_world_init(&world, c, number);
    dx_sensor_init(&sensor, g, c, number);
    for (uint32_t done = 0; done < n_cols; done += STRIP)
        cast_strip(plane, g, &world, &sensor, col0 + done,
                   n_cols - done < STRIP ? n_cols - done : STRIP);
}

double dx_scene_truth(const struct dx_geometry *g, const struct dx_scene_config *c, uint64_t number,
                      uint32_t row, uint32_t col)
{
    struct dx_world world;
    struct dx_sight sight;

    dx_world_init(&world, c, number);
    dx_sight_row(&sight, &world, g, row, col, 1);
    return sight.range;
}

void dx_scene_look(double *distance, const double *dir, size_t n, const struct dx_scene_config *c,
                   uint64_t number)
{
    struct dx_world world;

    dx_world_init(&world, c, number);
    for (size_t k = 0; k < n; k++, dir += 3)
        distance[k] = dx_sight_along(&world, dir).range *
                      sqrt(dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2]);
}
