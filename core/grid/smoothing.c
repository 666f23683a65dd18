/* The array of samples and its smoothed parts. */
#include "core/grid/smoothing.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

int dx_smoothing_new(struct dx_smoothing **out, const struct dx_geometry *g,
                     const struct dx_tiling *tiling, const struct dx_plane *like, double noise,
                     bool uneven)
{
    struct dx_smoothing *s = calloc(1, sizeof(*s));
    int r;

    if (!s)
        return -ENOMEM;
    s->tiling = tiling;
    s->geometry = g;
    s->stale = calloc(dx_marks_n_words(tiling), sizeof(*s->stale));
    s->task = calloc(dx_tiling_n_tiles(tiling), sizeof(*s->task));
    s->changed = calloc(dx_tiling_n_tiles(tiling), sizeof(*s->changed));
    r = s->stale && s->task && s->changed ? 0 : -ENOMEM;
    if (r == 0)
        r = dx_plane_init(&s->sampled, like->height, like->width, like->range_bytes,
                          like->attr_bytes);
    if (r == 0)
        r = dx_smooth_init(&s->smooth, g, noise, uneven);
    if (r < 0) {
        dx_smoothing_free(s);
        return r;
    }
    *out = s;
    return 0;
}

void dx_smoothing_free(struct dx_smoothing *s)
{
    if (!s)
        return;
    dx_smooth_fini(&s->smooth);
    dx_plane_fini(&s->sampled);
    free(s->changed);
    free(s->task);
    free(s->stale);
    free(s);
}

void dx_smoothing_set(struct dx_smoothing *s, const struct dx_gates *gates)
{
    dx_smooth_set(&s->smooth, gates);
    dx_marks_set_all(s->stale, s->tiling);
}

void dx_smoothing_mark(struct dx_smoothing *s, const struct dx_rect *dexels)
{
    dx_marks_set(s->stale, s->tiling, dexels, s->smooth.reach, s->smooth.reach);
}

static void smooth_part(void *ctx, uint32_t task, unsigned thread)
{
    struct dx_smoothing *s = ctx;

    dx_smooth_part(&s->smooth, s->out, &s->changed[task], &s->sampled, s->tiling, s->geometry,
                   s->task[task], thread);
}

uint32_t dx_smoothing_run(struct dx_smoothing *s, struct dx_plane *out, struct dx_pool *pool)
{
    uint32_t n = 0;

    for (uint32_t k = 0; k < dx_tiling_n_tiles(s->tiling); k++)
        if (dx_marks_has(s->stale, k))
            s->task[n++] = k;
    memset(s->stale, 0, dx_marks_n_words(s->tiling) * sizeof(*s->stale));
    s->out = out;
    dx_pool_run_tiles(pool, n, smooth_part, s);
    return n;
}
