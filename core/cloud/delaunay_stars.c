/* Stars of all points, in blocks of a task each, and what corners find of each other's triangles.
 */
#include "core/cloud/delaunay_priv.h"

#include <errno.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

struct scratch {
    struct dx_star_site site;
    struct dx_star star;
    uint32_t words[DX_STAR_BLOCK * DX_STAR_MAX];
};

struct make {
    struct dx_delaunay_run *run;
    struct scratch *scratch[DX_POOL_MAX_THREADS];
    atomic_uint n_widened;
    atomic_bool no_memory;
};

/* Units of the plane that the candidates must reach, so that no circle hides a point. */
static double widest_circle(const struct dx_star *star)
{
    double most = 0;

    for (uint32_t k = 0; k < star->n; k++)
        most = star->circle[k] > most ? star->circle[k] : most;
    return star->n < 3 ? INFINITY : most;
}

/* By the paper's radius: with points beyond the nearest neighbours, or without the farthest. */
static void make_printed(struct dx_star_site *site, struct dx_star *star,
                         const struct dx_delaunay_run *run)
{
    if (site->paper_radius > site->reach) {
        dx_star_widen(site, run, site->paper_radius);
    } else {
        const double most = site->paper_radius * site->plane.scale + 1;
        uint32_t n = 0;

        for (uint32_t k = 0; k < site->n; k++)
            if ((double)dx_flat_dot(site->at[k], site->at[k]) <= most * most) {
                site->rank[n] = site->rank[k];
                site->at[n++] = site->at[k];
            }
        site->n = n;
    }
    dx_star_scan(star, site->at, site->rank, site->n, site->plane.rank);
}

/* By circles: once more if one reaches beyond the nearest neighbours. */
static void make_empty(struct dx_star_site *site, struct dx_star *star,
                       const struct dx_delaunay_run *run, bool *widened)
{
    const double most = run->config->widest * site->reach;
    double need;

    dx_star_scan(star, site->at, site->rank, site->n, site->plane.rank);
    need = widest_circle(star) / site->plane.scale;
    if (need <= site->reach)
        return;
    dx_star_widen(site, run, need < most ? need * 1.001 + 1 : most);
    dx_star_scan(star, site->at, site->rank, site->n, site->plane.rank);
    *widened = true;
}

static bool is_long(const struct dx_delaunay_run *run, uint32_t a, uint32_t b)
{
    const int32_t *p = run->cloud->at[a], *q = run->cloud->at[b];
    const double d[3] = {p[0] - q[0], p[1] - q[1], p[2] - q[2]};

    return d[0] * d[0] + d[1] * d[1] + d[2] * d[2] > run->max_edge * run->max_edge;
}

uint32_t dx_star_make(uint32_t *words, struct dx_star_site *site, struct dx_star *star,
                      const struct dx_delaunay_run *run, uint32_t rank, bool *widened)
{
    double most = INFINITY;

    *widened = false;
    if (!dx_star_gather(site, run, rank) || site->n == 0)
        return 0;
    if (run->config->paper_radius) {
        make_printed(site, star, run);
    } else {
        make_empty(site, star, run, widened);
        most = site->reach * site->plane.scale;
    }
    for (uint32_t k = 0; k < star->n; k++) {
        const uint32_t next = star->rank[k + 1 < star->n ? k + 1 : 0];
        const bool gap = star->circle[k] == INFINITY || star->circle[k] > most ||
                         (run->max_edge < INFINITY && is_long(run, star->rank[k], next));

        words[k] = star->rank[k] | (gap ? DX_STAR_GAP : 0);
    }
    return star->n;
}

static uint32_t end_of_block(const struct dx_delaunay_run *run, uint32_t task)
{
    const uint32_t first = task * DX_STAR_BLOCK, n = run->cloud->n;

    return n - first < DX_STAR_BLOCK ? n : first + DX_STAR_BLOCK;
}

static void make_block(void *ctx, uint32_t task, unsigned thread)
{
    struct make *m = ctx;
    struct dx_stars *s = &m->run->stars;
    struct scratch *x = m->scratch[thread];
    const uint32_t end = end_of_block(m->run, task);
    uint32_t n_words = 0, n_widened = 0;

    for (uint32_t r = task * DX_STAR_BLOCK; r < end; r++) {
        bool widened;

        s->start[r] = n_words;
        s->count[r] =
            (uint8_t)dx_star_make(x->words + n_words, &x->site, &x->star, m->run, r, &widened);
        n_words += s->count[r];
        n_widened += widened;
    }
    s->word[task] = malloc(n_words * sizeof(uint32_t) + 1);
    s->vote[task] = malloc(n_words + 1);
    if (s->word[task] && s->vote[task])
        memcpy(s->word[task], x->words, n_words * sizeof(uint32_t));
    else
        atomic_store(&m->no_memory, true);
    atomic_fetch_add(&m->n_widened, n_widened);
}

/* The corner finds triangle (corner, a, b). */
static bool finds(const struct dx_stars *s, uint32_t corner, uint32_t a, uint32_t b)
{
    const uint32_t n = s->count[corner], *w = dx_star_words(s, corner);

    for (uint32_t k = 0; k < n; k++)
        if (w[k] == a) /* and no gap */
            return DX_STAR_RANK(w[k + 1 < n ? k + 1 : 0]) == b;
    return false;
}

static void count_votes(void *ctx, uint32_t task, unsigned thread)
{
    const struct make *m = ctx;
    const struct dx_stars *s = &m->run->stars;
    const uint32_t end = end_of_block(m->run, task);
    uint8_t *vote = s->vote[task];

    (void)thread;
    for (uint32_t r = task * DX_STAR_BLOCK; r < end; r++) {
        const uint32_t n = s->count[r], *w = dx_star_words(s, r);

        for (uint32_t k = 0; k < n; k++) {
            const uint32_t a = w[k], b = DX_STAR_RANK(w[k + 1 < n ? k + 1 : 0]);

            *vote++ = a & DX_STAR_GAP ? 0 : (uint8_t)(1 + finds(s, a, b, r) + finds(s, b, r, a));
        }
    }
}

static int reserve(struct make *m)
{
    struct dx_stars *s = &m->run->stars;
    const size_t n = m->run->cloud->n;
    const unsigned n_threads = m->run->pool ? dx_pool_threads(m->run->pool) : 1;

    s->n_blocks = (uint32_t)((n + DX_STAR_BLOCK - 1) / DX_STAR_BLOCK);
    s->word = calloc(s->n_blocks, sizeof(*s->word));
    s->vote = calloc(s->n_blocks, sizeof(*s->vote));
    s->start = malloc(n * sizeof(*s->start));
    s->count = malloc(n);
    if (!s->word || !s->vote || !s->start || !s->count)
        return -ENOMEM;
    for (unsigned k = 0; k < n_threads; k++) {
        m->scratch[k] = malloc(sizeof(*m->scratch[k]));
        if (!m->scratch[k])
            return -ENOMEM;
    }
    return 0;
}

int dx_stars_make(struct dx_delaunay_run *run)
{
    struct make m = {.run = run};
    int rc = reserve(&m);

    if (rc == 0) {
        dx_pool_run(run->pool, run->stars.n_blocks, make_block, &m);
        rc = atomic_load(&m.no_memory) ? -ENOMEM : 0;
    }
    if (rc == 0)
        dx_pool_run(run->pool, run->stars.n_blocks, count_votes, &m);
    run->stats->n_widened = atomic_load(&m.n_widened);
    for (unsigned k = 0; k < DX_POOL_MAX_THREADS; k++)
        free(m.scratch[k]);
    return rc;
}

void dx_stars_fini(struct dx_stars *s)
{
    for (uint32_t k = 0; k < s->n_blocks; k++) {
        if (s->word)
            free(s->word[k]);
        if (s->vote)
            free(s->vote[k]);
    }
    free(s->word);
    free(s->vote);
    free(s->start);
    free(s->count);
    *s = (struct dx_stars){0};
}
