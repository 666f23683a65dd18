/* The thread pool: every task exactly once, whoever runs it, generation after generation. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/pool.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <string.h>

#define MAX_TASKS 1000

static const unsigned thread_counts[] = {1, 2, 3, 8, 16};

struct job {
    atomic_uint runs[MAX_TASKS];
    atomic_uint bad_threads, in_use[64];
    unsigned n_threads;
};

static void count(void *ctx, uint32_t task, unsigned thread)
{
    struct job *job = ctx;

    if (thread >= job->n_threads || atomic_fetch_add(&job->in_use[thread], 1) != 0)
        atomic_fetch_add(&job->bad_threads, 1); /* two tasks at once would share scratch memory */
    atomic_fetch_add(&job->runs[task], 1);
    if (task % 16 == 0)
        sched_yield();
    if (thread < job->n_threads)
        atomic_fetch_sub(&job->in_use[thread], 1);
}

static unsigned wrong_runs(struct job *job, uint32_t n_tasks)
{
    unsigned wrong = atomic_load(&job->bad_threads);

    for (uint32_t k = 0; k < MAX_TASKS; k++)
        wrong += atomic_load(&job->runs[k]) != (k < n_tasks);
    return wrong;
}

static unsigned run_and_check(struct dx_pool *pool, struct job *job, uint32_t n_tasks)
{
    memset(job, 0, sizeof(*job));
    job->n_threads = dx_pool_threads(pool);
    dx_pool_run(pool, n_tasks, count, job);
    return wrong_runs(job, n_tasks);
}

static void each_task_exactly_once(void **state)
{
    static struct job job;

    (void)state;
    for (size_t k = 0; k < sizeof(thread_counts) / sizeof(thread_counts[0]); k++) {
        struct dx_pool *pool;

        assert_int_equal(dx_pool_new(&pool, thread_counts[k]), 0);
        assert_int_equal(dx_pool_threads(pool), thread_counts[k]);
        for (uint32_t generation = 0; generation < 300; generation++)
            assert_int_equal(run_and_check(pool, &job, generation % 40), 0);
        assert_int_equal(run_and_check(pool, &job, MAX_TASKS), 0);
        dx_pool_free(pool);
    }
}

static void without_a_pool_the_caller_works(void **state)
{
    static struct job job;

    (void)state;
    assert_int_equal(dx_pool_threads(NULL), 1);
    assert_int_equal(run_and_check(NULL, &job, 100), 0);
    dx_pool_free(NULL);
}

static void zero_is_one_per_processor(void **state)
{
    struct dx_pool *pool;

    (void)state;
    assert_int_equal(dx_pool_new(&pool, 0), 0);
    assert_in_range(dx_pool_threads(pool), 1, 64);
    dx_pool_free(pool);
    assert_int_equal(dx_pool_new(&pool, 1000), 0);
    assert_int_equal(dx_pool_threads(pool), 64);
    dx_pool_free(pool);
}

/* A pool that is freed before its threads have run, or straight after a job, must not hang. */
static void short_lives(void **state)
{
    static struct job job;

    (void)state;
    for (int k = 0; k < 200; k++) {
        struct dx_pool *pool;

        assert_int_equal(dx_pool_new(&pool, 4), 0);
        if (k % 2)
            assert_int_equal(run_and_check(pool, &job, 5), 0);
        dx_pool_free(pool);
    }
}

/* What a task wrote must be seen by the caller without any atomics of its own. */
static void square(void *ctx, uint32_t task, unsigned thread)
{
    (void)thread;
    ((uint64_t *)ctx)[task] = (uint64_t)task * task + ((uint64_t *)ctx)[MAX_TASKS];
}

static void results_are_visible(void **state)
{
    static uint64_t out[MAX_TASKS + 1];
    struct dx_pool *pool;

    (void)state;
    assert_int_equal(dx_pool_new(&pool, 3), 0);
    for (uint64_t generation = 0; generation < 200; generation++) {
        out[MAX_TASKS] = generation;
        dx_pool_run(pool, MAX_TASKS, square, out);
        for (uint64_t k = 0; k < MAX_TASKS; k++)
            assert_int_equal(out[k], k * k + generation);
    }
    dx_pool_free(pool);
}

struct caller {
    struct dx_pool *pool;
    pthread_t thread;
    struct job job;
    unsigned wrong;
};

static void *call_often(void *arg)
{
    struct caller *c = arg;

    for (uint32_t generation = 0; generation < 200; generation++)
        c->wrong += run_and_check(c->pool, &c->job, generation % 30);
    return NULL;
}

static void callers_take_turns(void **state)
{
    static struct caller callers[4];
    struct dx_pool *pool;

    (void)state;
    assert_int_equal(dx_pool_new(&pool, 3), 0);
    for (int k = 0; k < 4; k++) {
        callers[k].pool = pool;
        assert_int_equal(pthread_create(&callers[k].thread, NULL, call_often, &callers[k]), 0);
    }
    for (int k = 0; k < 4; k++) {
        pthread_join(callers[k].thread, NULL);
        assert_int_equal(callers[k].wrong, 0);
    }
    dx_pool_free(pool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_task_exactly_once),
        cmocka_unit_test(without_a_pool_the_caller_works),
        cmocka_unit_test(zero_is_one_per_processor),
        cmocka_unit_test(short_lives),
        cmocka_unit_test(results_are_visible),
        cmocka_unit_test(callers_take_turns),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
