/* Rays to sights, sights to dexels. */
#include "drivers/synth/sight.h"

#include "core/base/rng.h"

#include <math.h>

#define MIX_STEP_M 0.3 /* a mixed pixel needs a step of more than this */

static struct dx_sight look(const struct dx_world *w, const struct dx_ray *ray)
{
    struct dx_sight sight = {INFINITY, 0};
    const struct dx_shape *nearest = NULL;
    int face = 0;

    for (unsigned k = 0; k < w->n; k++) {
        int side;
        double t = dx_shape_hit(&w->shape[k], ray, &side);

        if (t < sight.range) {
            sight.range = t;
            nearest = &w->shape[k];
            face = side;
        }
    }
    if (nearest)
        sight.shade = (float)dx_shape_shade(nearest, ray, sight.range, face, w->up, w->up_sign);
    return sight;
}

struct dx_sight dx_sight_along(const struct dx_world *w, const double dir[3])
{
    struct dx_ray ray = dx_ray_make(dir[0], dir[1], dir[2]);

    return look(w, &ray);
}

/* The ray of a dexel in double, from the geometry's own f32 tables: a range along it gives the
 * geometry's point but for rounding. */
static struct dx_ray ray_of(const struct dx_geometry *g, uint32_t row, uint32_t col)
{
    if (g->model == DX_MODEL_PINHOLE)
        return dx_ray_make((double)g->table[col], (double)g->table[(size_t)g->width + row], 1);

    const float *cs = g->table + 2 * (size_t)col;
    const float *d = g->table + 2 * (size_t)g->width + 6 * (size_t)row;
    double x = (double)d[0], y = (double)d[1], c = (double)cs[0], s = (double)cs[1];

    return dx_ray_make(x * c - y * s, x * s + y * c, (double)d[2]);
}

void dx_sight_row(struct dx_sight *out, const struct dx_world *w, const struct dx_geometry *g,
                  uint32_t row, int64_t col0, uint32_t n)
{
    int64_t width = g->width;

    for (uint32_t k = 0; k < n; k++) {
        int64_t col = col0 + k;
        struct dx_ray ray;

        if (g->wrap)
            col = (col % width + width) % width;
        if (col < 0 || col >= width) {
            out[k] = (struct dx_sight){INFINITY, 0};
            continue;
        }
        ray = ray_of(g, row, (uint32_t)col);
        out[k] = look(w, &ray);
    }
}

void dx_sensor_init(struct dx_sensor *s, const struct dx_geometry *g,
                    const struct dx_scene_config *c, uint64_t number)
{
    s->config = c;
    s->unit_m = (double)g->unit_m;
    s->max_units = g->range_bytes == 2 ? 65535.0 : 4294967295.0;
    s->attr_scale = c->attr_bytes == 1 ? 255 : 65535;
    s->noisy = c->sigma[0] > 0 || c->sigma[1] > 0 || c->sigma[2] > 0;
    s->frame_hash = dx_hash_u64(0, number);
}

enum draw { DRAW_DROPOUT, DRAW_MIXED, DRAW_NOISE, N_DRAWS };

/* Each purpose draws from a stream of its own, so that one setting does not change another's draws.
 */
static struct dx_rng rng_of(const struct dx_sensor *s, uint64_t row_hash, uint32_t col,
                            enum draw purpose)
{
    uint64_t stream = dx_hash_u64(row_hash, (uint64_t)col * N_DRAWS + purpose);

    return dx_rng_init(s->config->seed, stream);
}

/* The neighbour at the largest step, or NULL when none is more than MIX_STEP_M away. */
static const struct dx_sight *step_partner(const struct dx_sight *here,
                                           const struct dx_sight *above,
                                           const struct dx_sight *below)
{
    const struct dx_sight *around[4] = {here - 1, here + 1, above, below}, *partner = NULL;
    double largest = MIX_STEP_M;

    for (int k = 0; k < 4; k++) {
        if (!around[k] || isinf(around[k]->range))
            continue;
        if (fabs(around[k]->range - here->range) > largest) {
            largest = fabs(around[k]->range - here->range);
            partner = around[k];
        }
    }
    return partner;
}

static struct dx_sight mix(const struct dx_sight *a, const struct dx_sight *b, double weight)
{
    return (struct dx_sight){
        a->range + weight * (b->range - a->range),
        (float)((double)a->shade + weight * ((double)b->shade - (double)a->shade))};
}

/* What the sensor measures where the beam meets here[0]. */
static struct dx_sight measure(const struct dx_sensor *s, uint64_t row_hash, uint32_t col,
                               const struct dx_sight *here, const struct dx_sight *above,
                               const struct dx_sight *below)
{
    const struct dx_scene_config *c = s->config;
    struct dx_sight sight = *here;

    if (isinf(sight.range))
        return sight;
    if (c->mixed > 0) {
        const struct dx_sight *partner = step_partner(here, above, below);
        struct dx_rng rng = rng_of(s, row_hash, col, DRAW_MIXED);

        if (partner && dx_rng_unit(&rng) < c->mixed)
            sight = mix(here, partner, dx_rng_unit(&rng));
    }
    if (s->noisy) {
        struct dx_rng rng = rng_of(s, row_hash, col, DRAW_NOISE);
        double r = sight.range;

        sight.range += (c->sigma[0] + r * (c->sigma[1] + r * c->sigma[2])) * dx_rng_normal(&rng);
    }
    if (c->dropout > 0) {
        struct dx_rng rng = rng_of(s, row_hash, col, DRAW_DROPOUT);

        if (dx_rng_unit(&rng) < c->dropout)
            sight.range = INFINITY;
    }
    return sight;
}

void dx_sensor_row(struct dx_plane *plane, const struct dx_sensor *s, uint32_t row, uint32_t col0,
                   uint32_t n, const struct dx_sight *here, const struct dx_sight *above,
                   const struct dx_sight *below)
{
    uint64_t row_hash = dx_hash_u64(s->frame_hash, row);
    size_t dexel = (size_t)row * plane->width + col0;

    for (uint32_t k = 0; k < n; k++) {
        struct dx_sight sight = measure(s, row_hash, col0 + k, here + k, above ? above + k : NULL,
                                        below ? below + k : NULL);
        double units = sight.range / s->unit_m + 0.5;
        bool valid = units >= 1 && units < s->max_units + 1;

        dx_plane_set_range(plane, dexel + k, valid ? (uint32_t)units : 0);
        dx_plane_set_attr(plane, dexel + k,
                          valid ? (uint32_t)((double)sight.shade * s->attr_scale + 0.5) : 0);
    }
}
