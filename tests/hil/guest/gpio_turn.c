/*
 * gpio_turn FOLDER RPM COUNTS TRACK: turns the encoder of a simulated stage for good, by lines 0
 * (A), 1 (B) and 2 (index) of a simulated chip. The stage stands where dexeld takes a stage of this
 * speed to stand that turns by itself: at angle 0 when the monotonic clock is 0. The file TRACK
 * tells when the counts came in truth (scip_track.h).
 */
#include "tests/hil/guest/sim_lines.h"
#include "tests/hil/scip_track.h"

#include <sched.h>
#include <stdint.h>
#include <time.h>

#define WIDTH 3 /* counts that the index is high */

static const char *const words[2] = {"pull-down", "pull-up"};

static void put(int fd, bool up)
{
    if (pwrite(fd, words[up], strlen(words[up]), 0) != (ssize_t)strlen(words[up]))
        die("pull", strerror(errno));
}

static uint64_t time_ns(const struct timespec *t)
{
    return (uint64_t)t->tv_sec * 1000000000u + (uint64_t)t->tv_nsec;
}

int main(int argc, char **argv)
{
    static const bool a[4] = {false, true, true, false}, b[4] = {false, false, true, true};
    const struct sched_param first = {.sched_priority = 50};
    struct timespec t;
    double count_ns;
    struct scip_track *track;
    uint64_t count, counts;
    int fd[3];

    if (argc != 5)
        die("gpio_turn", "FOLDER RPM COUNTS TRACK");
    sim_folder = argv[1];
    counts = strtoul(argv[3], NULL, 10);
    count_ns = 60e9 / strtod(argv[2], NULL) / (double)counts;
    track = scip_track_map(argv[4], O_RDWR | O_CREAT);
    if (!track)
        die(argv[4], strerror(errno));
    track->counts = counts;
    track->count_ns = (uint64_t)count_ns;
    for (unsigned k = 0; k < 3; k++)
        fd[k] = sim_open(k, "pull", O_WRONLY);
    if (sched_setscheduler(0, SCHED_FIFO, &first))
        die("priority", strerror(errno));
    clock_gettime(CLOCK_MONOTONIC, &t);
    count = (uint64_t)((double)time_ns(&t) / count_ns);
    for (;; count++) {
        uint64_t due_ns = (uint64_t)((double)count * count_ns);

        t = (struct timespec){(time_t)(due_ns / 1000000000), (long)(due_ns % 1000000000)};
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
        clock_gettime(CLOCK_MONOTONIC, &t);
        scip_track_put(track, count, time_ns(&t));
        put(fd[0], a[count & 3]);
        put(fd[1], b[count & 3]);
        put(fd[2], count % counts < WIDTH);
    }
}
