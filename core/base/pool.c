/*
 * The thread pool: workers sleep on a condition until a job is open. Its caller works too, closes
 * it when no task is left, and waits for those alone that have joined: one that has not woken yet
 * finds it closed. So a job of a few tasks does not take as long as a thread takes to wake.
 *
 * A frame is several jobs, one right after the other, and to wake takes as long as a good part of
 * one: so who waits looks a while, and lets others run, before it sleeps.
 */
#include "core/base/pool.h"

#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <unistd.h>

/* What one thread does in the 50 us and more that another takes to wake. */
#define FEW_TILES 8

/* So often: some 50 us. */
#define LOOKS 200

/* The tasks that are left of a thread's part: first (low half) to end (high half). Its owner takes
 * them from the front, others from the back. The jobs of a frame have about the same tasks: so a
 * thread finds most of what it needs of the job before in its own cache, and another's is far. */
struct share {
    _Atomic uint64_t left;
    char apart[56]; /* a cache line each */
};

struct worker {
    struct dx_pool *pool;
    pthread_t thread;
    unsigned number;
};

struct dx_pool {
    pthread_mutex_t turn; /* held by the caller whose job runs */
    pthread_mutex_t lock; /* guards generation, is_open, n_busy, stop: both atomic ones are looked
                             at without it, and then with it */
    pthread_cond_t start, done;
    atomic_uint generation; /* counts jobs: a worker joins each once */
    bool is_open;
    atomic_uint n_busy; /* workers that have joined and not finished */
    bool stop;
    /* The job: written under the lock while none is open and nobody is busy, read by who joined. */
    void (*fn)(void *, uint32_t, unsigned);
    void *ctx;
    struct share share[DX_POOL_MAX_THREADS]; /* of the tasks, by thread */
    unsigned n_workers;
    struct worker worker[DX_POOL_MAX_THREADS - 1];
};

/* relaxed: the job itself was ordered by the lock; shares only deal out numbers */
static bool take(struct share *share, bool is_own, uint32_t *task)
{
    uint64_t left = atomic_load_explicit(&share->left, memory_order_relaxed), rest;

    do {
        const uint32_t first = (uint32_t)left, end = (uint32_t)(left >> 32);

        if (first == end)
            return false;
        *task = is_own ? first : end - 1;
        rest = is_own ? left + 1 : left - ((uint64_t)1 << 32);
    } while (!atomic_compare_exchange_weak_explicit(&share->left, &left, rest, memory_order_relaxed,
                                                    memory_order_relaxed));
    return true;
}

static void take_tasks(struct dx_pool *pool, unsigned number)
{
    const unsigned n = pool->n_workers + 1;
    uint32_t task;

    for (unsigned k = 0; k < n; k++)
        while (take(&pool->share[(number + k) % n], k == 0, &task))
            pool->fn(pool->ctx, task, number);
}

static void deal(struct dx_pool *pool, uint32_t n_tasks)
{
    const uint64_t n = pool->n_workers + 1;

    for (uint64_t k = 0; k < n; k++)
        atomic_store_explicit(&pool->share[k].left, (k + 1) * n_tasks / n << 32 | k * n_tasks / n,
                              memory_order_relaxed);
}

/* Until `number` is (or is not) `value`, or for a while. */
static void look(const atomic_uint *number, unsigned value, bool is)
{
    for (int k = 0;
         k < LOOKS && (atomic_load_explicit(number, memory_order_relaxed) == value) != is; k++)
        sched_yield();
}

static void *worker_main(void *arg)
{
    struct worker *w = arg;
    struct dx_pool *pool = w->pool;
    unsigned seen = 0;

    pthread_mutex_lock(&pool->lock);
    for (;;) {
        while ((pool->generation == seen || !pool->is_open) && !pool->stop)
            pthread_cond_wait(&pool->start, &pool->lock);
        if (pool->stop)
            break;
        seen = pool->generation;
        pool->n_busy++;
        pthread_mutex_unlock(&pool->lock);
        take_tasks(pool, w->number);
        pthread_mutex_lock(&pool->lock);
        if (--pool->n_busy == 0)
            pthread_cond_signal(&pool->done);
        pthread_mutex_unlock(&pool->lock);
        look(&pool->generation, seen, false);
        pthread_mutex_lock(&pool->lock);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

int dx_pool_new(struct dx_pool **out, unsigned n_threads)
{
    struct dx_pool *pool = calloc(1, sizeof(*pool));
    long cpus = sysconf(_SC_NPROCESSORS_ONLN);

    if (!pool)
        return -ENOMEM;
    if (n_threads == 0)
        n_threads = cpus > 0 ? (unsigned)cpus : 1;
    if (n_threads > DX_POOL_MAX_THREADS)
        n_threads = DX_POOL_MAX_THREADS;
    pthread_mutex_init(&pool->turn, NULL);
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->start, NULL);
    pthread_cond_init(&pool->done, NULL);
    for (unsigned k = 0; k + 1 < n_threads; k++) {
        struct worker *w = &pool->worker[k];
        int r;

        w->pool = pool;
        w->number = k + 1;
        r = pthread_create(&w->thread, NULL, worker_main, w);
        if (r) {
            dx_pool_free(pool);
            return -r;
        }
        pool->n_workers++;
    }
    *out = pool;
    return 0;
}

void dx_pool_free(struct dx_pool *pool)
{
    if (!pool)
        return;
    pthread_mutex_lock(&pool->lock);
    pool->stop = true;
    pthread_cond_broadcast(&pool->start);
    pthread_mutex_unlock(&pool->lock);
    for (unsigned k = 0; k < pool->n_workers; k++)
        pthread_join(pool->worker[k].thread, NULL);
    pthread_cond_destroy(&pool->done);
    pthread_cond_destroy(&pool->start);
    pthread_mutex_destroy(&pool->lock);
    pthread_mutex_destroy(&pool->turn);
    free(pool);
}

unsigned dx_pool_threads(const struct dx_pool *pool)
{
    return pool ? pool->n_workers + 1 : 1;
}

void dx_pool_run(struct dx_pool *pool, uint32_t n_tasks, void (*fn)(void *, uint32_t, unsigned),
                 void *ctx)
{
    if (!pool || pool->n_workers == 0 || n_tasks <= 1) {
        for (uint32_t k = 0; k < n_tasks; k++)
            fn(ctx, k, 0);
        return;
    }
    pthread_mutex_lock(&pool->turn);
    pthread_mutex_lock(&pool->lock);
    pool->fn = fn;
    pool->ctx = ctx;
    deal(pool, n_tasks);
    pool->generation++;
    pool->is_open = true;
    pthread_cond_broadcast(&pool->start);
    pthread_mutex_unlock(&pool->lock);

    take_tasks(pool, 0);

    pthread_mutex_lock(&pool->lock);
    pool->is_open = false;
    pthread_mutex_unlock(&pool->lock);
    look(&pool->n_busy, 0, true);
    pthread_mutex_lock(&pool->lock);
    while (pool->n_busy)
        pthread_cond_wait(&pool->done, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
    pthread_mutex_unlock(&pool->turn);
}

struct dx_pool *dx_pool_for_tiles(struct dx_pool *pool, uint32_t n_tiles)
{
    return n_tiles > FEW_TILES ? pool : NULL;
}

void dx_pool_run_tiles(struct dx_pool *pool, uint32_t n_tiles,
                       void (*fn)(void *, uint32_t, unsigned), void *ctx)
{
    dx_pool_run(dx_pool_for_tiles(pool, n_tiles), n_tiles, fn, ctx);
}
