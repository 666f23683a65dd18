/*
 * room_check SOCKET N X0 Y0 Z0 X1 Y1 Z1: a subscriber of a scanner that stands in a box-shaped
 * room. In each of N whole frames each of the six walls must have vertices, and each vertex must
 * lie on a wall: all within FAR_M, and on average within NEAR_M (the stage turns while clocks
 * differ by milliseconds).
 */
#include "client/dexel.h"

#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SILENCE_MS 60000
#define DONE       1
#define FAR_M      0.1
#define NEAR_M     0.02
#define LEAST      1000 /* vertices of a frame */
#define LEAST_WALL 30   /* vertices of a wall */

struct place {
    float xyz[3];
    int held;
};

static struct {
    double room[6];
    uint32_t width, height;
    struct place *place; /* of each dexel */
    unsigned n_frames, n_wanted;
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

/* From a point to the nearest wall, which gets one more. */
static double off_wall(const float p[3], unsigned n_of[6])
{
    double best = INFINITY;
    int wall = 0;

    for (int k = 0; k < 6; k++) {
        double off = fabs(p[k % 3] - check.room[k]);

        wall = off < best ? k : wall;
        best = fmin(best, off);
    }
    n_of[wall]++;
    return best;
}

static int on_commit(void *user, const struct dexel_commit *c)
{
    double sum = 0, worst = 0;
    unsigned n = 0, n_of[6] = {0}, least = UINT_MAX;

    (void)user;
    if (c->partial)
        return 0;
    for (size_t i = 0; i < (size_t)check.width * check.height; i++) {
        double off = check.place[i].held ? off_wall(check.place[i].xyz, n_of) : 0;

        n += check.place[i].held != 0;
        sum += off;
        worst = fmax(worst, off);
    }
    for (int k = 0; k < 6; k++)
        least = n_of[k] < least ? n_of[k] : least;
    printf("frame %llu: %u vertices, %u or more on a wall, %.4f m off on average, %.4f m at most\n",
           (unsigned long long)c->frame, n, least, sum / n, worst);
    if (c->frame == 0)
        return 0; /* it began anywhere */
    if (n < LEAST || least < LEAST_WALL || worst > FAR_M || sum / n > NEAR_M)
        die("expected %u vertices, %u on a wall, %g m on average, %g m at most", LEAST, LEAST_WALL,
            NEAR_M, FAR_M);
    return ++check.n_frames == check.n_wanted ? DONE : 0;
}

int main(int argc, char **argv)
{
    static const struct dexel_callbacks callbacks = {
        .stream = on_stream, .tile = on_tile, .commit = on_commit};
    struct dexel_options options = {.encoding = DEXEL_F32};
    struct dexel *d;
    int r;

    if (argc != 9)
        die("usage: room_check SOCKET N X0 Y0 Z0 X1 Y1 Z1");
    options.socket = argv[1];
    check.n_wanted = (unsigned)strtoul(argv[2], NULL, 10);
    for (int k = 0; k < 6; k++)
        check.room[k] = strtod(argv[3 + k], NULL);
    r = dexel_open(&d, &options, &callbacks, NULL);
    if (r == 0)
        r = dexel_run(d, SILENCE_MS);
    if (r < 0)
        die("%s", dexel_error(d));
    dexel_close(d);
    return r != DONE;
}
