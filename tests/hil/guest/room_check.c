/*
 * room_check SOCKET N X0 Y0 Z0 X1 Y1 Z1 [still|STREAM]: a subscriber of a scanner (the only stream,
 * or the one named) that stands in a box-shaped room, on a turning stage. In each of N whole
 * frames, the first left out, a third of the dexels must have a vertex, and each must lie on a
 * wall: all within FAR_M, on average within MEAN_M. FAR_M is what one count of an encoder with 400
 * is in a corner 4 m away, 63 mm, and some milliseconds between the scanner's clock and ours. In
 * two frames or more, half a turn each, all six walls must have been seen.
 *
 * still: the scanner does not turn, though the service takes it for turning. Then each scan is the
 * same, and the mesh is the body of revolution of it: floor and ceiling, and a cylinder of the
 * radius X1 (a scanner with a blind third sees none of the wall behind it), whatever anybody's
 * clock says. Within EXACT_M: the scanner tells millimetres.
 */
#include "client/dexel.h"

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SILENCE_MS 60000
#define DONE       1
#define MEAN_M     0.01
#define FAR_M      0.1
#define EXACT_M    0.001
#define LEAST_WALL 100 /* vertices of a wall, in all frames together */

struct place {
    float xyz[3];
    int held;
};

static struct {
    double room[6];
    bool still;
    uint32_t width, height;
    struct place *place; /* of each dexel */
    unsigned n_seen, n_frames, n_wanted;
    unsigned long n_of[6]; /* vertices of each wall */
} check;

__attribute__((format(printf, 1, 2), noreturn)) static void die(const char *fmt, ...)
{
    va_list ap;

    va_start(ap, fmt);
    vfprintf(stderr, fmt, ap);
    va_end(ap);
    fputc('\n', stderr);
    exit(1);
}

static int on_stream(void *user, const struct dexel_stream *s)
{
    (void)user;
    check.width = s->width;
    check.height = s->height;
    free(check.place);
    check.place = calloc((size_t)s->width * s->height, sizeof(*check.place));
    printf("%u x %u dexels\n", s->width, s->height);
    return check.place ? 0 : -1;
}

static int on_tile(void *user, const struct dexel_tile *t)
{
    (void)user;
    for (uint32_t row = t->row * 64; row < t->row * 64 + 64 && row < check.height; row++)
        for (uint32_t col = t->col * 64; col < t->col * 64 + 64 && col < check.width; col++)
            check.place[row * check.width + col].held = 0;
    for (uint32_t i = 0; i < t->n_vertices; i++) {
        struct place *p = &check.place[t->dexel[i]];

        memcpy(p->xyz, t->xyz + 3 * i, sizeof(p->xyz));
        p->held = 1;
    }
    return 0;
}

static int n_walls(void)
{
    return check.still ? 3 : 6;
}

/* From a point to a wall. */
static double off(const float p[3], int wall)
{
    double away = hypot((double)p[0], (double)p[1]);

    if (!check.still)
        return fabs(p[wall % 3] - check.room[wall]);
    return wall < 2 ? fabs(p[2] - check.room[2 + 3 * wall]) : fabs(away - check.room[3]);
}

/* From a point to the nearest wall, which gets one more. */
static double off_walls(const float p[3], unsigned n_of[6])
{
    double best = INFINITY;
    int wall = 0;

    for (int k = 0; k < n_walls(); k++) {
        double far = off(p, k);

        wall = far < best ? k : wall;
        best = fmin(best, far);
    }
    n_of[wall]++;
    return best;
}

static int on_commit(void *user, const struct dexel_commit *c)
{
    size_t n_dexels = (size_t)check.width * check.height, n = 0;
    double far_m = check.still ? EXACT_M : FAR_M;
    unsigned n_of[6] = {0};
    double sum = 0, worst = 0;

    (void)user;
    if (c->partial)
        return 0;
    for (size_t i = 0; i < n_dexels; i++) {
        double far = check.place[i].held ? off_walls(check.place[i].xyz, n_of) : 0;

        n += check.place[i].held != 0;
        sum += far;
        worst = fmax(worst, far);
    }
    printf("frame %llu: %zu vertices, %.4f m off the walls on average, %.4f m at most\n",
           (unsigned long long)c->frame, n, sum / (double)n, worst);
    if (check.n_seen++ == 0)
        return 0; /* it began anywhere */
    if (n < n_dexels / 3 || worst > far_m || sum / (double)n > MEAN_M)
        die("expected %zu vertices, %g m on average, %g m at most", n_dexels / 3, MEAN_M, far_m);
    for (int k = 0; k < 6; k++)
        check.n_of[k] += n_of[k];
    return ++check.n_frames == check.n_wanted ? DONE : 0;
}

static void expect_all_walls(void)
{
    printf("vertices of the walls: %lu %lu %lu %lu %lu %lu\n", check.n_of[0], check.n_of[1],
           check.n_of[2], check.n_of[3], check.n_of[4], check.n_of[5]);
    for (int k = 0; k < n_walls(); k++)
        if (check.n_of[k] < LEAST_WALL)
            die("expected %u or more of each", LEAST_WALL);
}

int main(int argc, char **argv)
{
    static const struct dexel_callbacks callbacks = {
        .stream = on_stream, .tile = on_tile, .commit = on_commit};
    struct dexel_options options = {.encoding = DEXEL_F32};
    struct dexel *d;
    int r;

    check.still = argc == 10 && !strcmp(argv[9], "still");
    if (argc != 9 && argc != 10)
        die("usage: room_check SOCKET N X0 Y0 Z0 X1 Y1 Z1 [still|STREAM]");
    options.socket = argv[1];
    options.stream = check.still ? NULL : argv[9];
    check.n_wanted = (unsigned)strtoul(argv[2], NULL, 10);
    for (int k = 0; k < 6; k++)
        check.room[k] = strtod(argv[3 + k], NULL);
    r = dexel_open(&d, &options, &callbacks, NULL);
    if (r == 0)
        r = dexel_run(d, SILENCE_MS);
    if (r < 0)
        die("%s", dexel_error(d));
    dexel_close(d);
    if (check.n_wanted > 1)
        expect_all_walls();
    return r != DONE;
}
