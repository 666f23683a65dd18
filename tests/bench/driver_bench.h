/*
 * What a driver of a device costs at its full rate: the service's own reader thread with a device
 * that is simulated, a mesher that only takes, and two measures of it. Latency runs from the moment
 * at which a frame's last byte was there for the driver (the simulation knows) until the frame was
 * in the mailbox: waking the thread is in it. The processor's share is of the reader's thread
 * alone. Prints a row of a table.
 */
#ifndef DRIVER_BENCH_H
#define DRIVER_BENCH_H

#include "daemon/log.h"
#include "daemon/reader.h"
#include "tools/bench.h"
#include "tools/now.h"

#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define DRIVER_BENCH_MAX 65536

struct driver_bench {
    const char *name; /* of the row */
    const struct dx_driver *driver;
    const void *config;
    double hz; /* at which the device makes frames (a scanner: scans) */
    /* When the last byte of the newest one was there; 0: none yet. The reader's thread asks. */
    uint64_t (*last_byte_ns)(void);

    struct dx_mailbox *mailbox;
    struct dx_stream_reader *reader;
    struct dx_counters counters;
    pthread_t thread;
    sem_t mail;
    atomic_bool runs, ends;
    uint64_t seen_ns; /* the last byte that was counted last */
    double latency_us[DRIVER_BENCH_MAX];
    uint32_t n;
};

/* In the reader's thread, for each part of a frame. */
static void driver_bench_mail(void *bench)
{
    struct driver_bench *b = bench;
    uint64_t last_ns = b->last_byte_ns(), now = dx_now_ns();

    if (atomic_load(&b->runs) && last_ns && last_ns != b->seen_ns && b->n < DRIVER_BENCH_MAX)
        b->latency_us[b->n++] = (double)(now - last_ns) * 1e-3;
    b->seen_ns = last_ns;
    sem_post(&b->mail);
}

static void *driver_bench_read(void *bench)
{
    dx_stream_reader_run(((struct driver_bench *)bench)->reader);
    return NULL;
}

/* The mesher's part: takes what comes, as fast as it comes. */
static void *driver_bench_take(void *bench)
{
    struct driver_bench *b = bench;
    struct dx_mail_item item;

    while (!atomic_load(&b->ends)) {
        sem_wait(&b->mail);
        while (dx_mailbox_take(b->mailbox, &item) != DX_MAIL_NONE) {
            if (item.kind == DX_MAIL_GEOMETRY)
                dx_geometry_unref(item.geometry);
            else if (item.kind == DX_MAIL_COLUMNS)
                dx_mailbox_release(b->mailbox);
        }
    }
    return NULL;
}

static double driver_bench_cpu_s(pthread_t thread)
{
    struct timespec t = {0, 0};
    clockid_t clock;

    if (pthread_getcpuclockid(thread, &clock) == 0)
        clock_gettime(clock, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static void driver_bench_sleep(double seconds)
{
    struct timespec t = {(time_t)seconds, (long)((seconds - (double)(time_t)seconds) * 1e9)};

    nanosleep(&t, NULL);
}

static void driver_bench_print(struct driver_bench *b, double cpu_s, double seconds)
{
    struct dx_reader_device_status s;

    dx_reader_device_status(dx_stream_reader_attached(b->reader), &s);
    if (b->n == 0) { /* it never streamed: what it lacked stands there */
        printf("| %s | %.0f | 0 | %s | | | | | |\n", b->name, b->hz,
               s.reason[0] ? s.reason : "no frame came");
        return;
    }
    qsort(b->latency_us, b->n, sizeof(b->latency_us[0]), dx_bench_by_value);
    printf("| %s | %.0f | %u | %llu | %.2f | %.0f | %.0f | %.0f | %.0f |\n", b->name, b->hz, b->n,
           (unsigned long long)s.health.n_lost + s.health.n_damaged, 100 * cpu_s / seconds,
           1e6 * cpu_s / b->n, b->latency_us[b->n / 2], b->latency_us[b->n * 99 / 100],
           b->latency_us[b->n - 1]);
}

/* 0; 1 when it could not be measured. */
static int driver_bench_run(struct driver_bench *b, double seconds)
{
    struct dx_err err = {""};
    double cpu_s, begun_s;
    pthread_t taker;
    uint64_t start_ns;

    dx_log_set_level(-1);
    sem_init(&b->mail, 0, 0);
    if (dx_mailbox_new(&b->mailbox, false, driver_bench_mail, b) ||
        dx_stream_reader_new(&b->reader, "bench", b->driver, b->config, b->mailbox, &b->counters,
                             &err)) {
        fprintf(stderr, "%s: %s\n", b->name, err.text);
        return 1;
    }
    if (pthread_create(&b->thread, NULL, driver_bench_read, b) != 0 ||
        pthread_create(&taker, NULL, driver_bench_take, b) != 0)
        return 1;
    driver_bench_sleep(3); /* it starts, and all is warm */
    start_ns = dx_now_ns();
    begun_s = driver_bench_cpu_s(b->thread);
    atomic_store(&b->runs, true);
    driver_bench_sleep(seconds);
    atomic_store(&b->runs, false);
    cpu_s = driver_bench_cpu_s(b->thread) - begun_s;
    seconds = dx_seconds_since(start_ns);
    dx_mailbox_close(b->mailbox);
    dx_stream_reader_stop(b->reader);
    pthread_join(b->thread, NULL);
    atomic_store(&b->ends, true);
    sem_post(&b->mail);
    pthread_join(taker, NULL);
    if (b->n == 0)
        fprintf(stderr, "%s: no frame came\n", b->name);
    else
        driver_bench_print(b, cpu_s, seconds);
    dx_stream_reader_free(b->reader);
    dx_mailbox_free(b->mailbox);
    sem_destroy(&b->mail);
    return b->n == 0;
}

/* Seconds to measure, of the command line. */
static double driver_bench_seconds(int argc, char **argv)
{
    return argc > 1 ? strtod(argv[1], NULL) : 5;
}

#endif
