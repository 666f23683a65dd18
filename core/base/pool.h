/*
 * A pool of threads for work that falls into independent tasks (tiles). dx_pool_run returns when
 * every task is done. Each thread begins with its own part of the tasks, and helps the others when
 * it has done that: which thread runs which task varies, and a task must write only what belongs to
 * it. Callers (the meshers of all streams) take turns.
 */
#ifndef DX_POOL_H
#define DX_POOL_H

#include <stdint.h>

#define DX_POOL_MAX_THREADS 64

struct dx_pool;

/* `n_threads` counts the caller: 1 makes no thread, 0 takes one per processor (at most 64).
 * Errors: -ENOMEM, -EAGAIN from pthread_create. */
int dx_pool_new(struct dx_pool **out, unsigned n_threads);
void dx_pool_free(struct dx_pool *pool);
unsigned dx_pool_threads(const struct dx_pool *pool);

/* Calls fn(ctx, task, thread) for task 0..n_tasks-1; `thread` is 0..dx_pool_threads()-1 and picks
 * scratch memory. `pool` may be NULL: all runs on the caller. Allocates nothing. */
void dx_pool_run(struct dx_pool *pool, uint32_t n_tasks,
                 void (*fn)(void *ctx, uint32_t task, unsigned thread), void *ctx);

/* The pool, or NULL where the work is that of a few tiles, each of which takes microseconds: the
 * caller has done them sooner than another thread wakes. */
struct dx_pool *dx_pool_for_tiles(struct dx_pool *pool, uint32_t n_tiles);

/* Runs where a task is such a tile. */
void dx_pool_run_tiles(struct dx_pool *pool, uint32_t n_tiles,
                       void (*fn)(void *ctx, uint32_t task, unsigned thread), void *ctx);

#endif
