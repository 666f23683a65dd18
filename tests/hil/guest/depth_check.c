/*
 * depth_check SOCKET STREAM N FX FY CX CY [FILE]: a subscriber that knows what a simulated depth
 * camera shows: depth_pattern(), or the 16-bit pixels of FILE, in millimetres. After each of N
 * commits it must hold a vertex for every pixel with a depth, none elsewhere, each at that depth
 * exactly and on that pixel's ray, all of the same frame.
 */
#include "client/dexel.h"
#include "tests/hil/depth_pattern.h"
#include "tests/hil/guest/video.h"

#include <math.h>
#include <stdbool.h>

#define SILENCE_MS 20000
#define DONE       1

static struct {
    double fx, fy, cx, cy;
    const char *file;
    uint32_t width, height;
    uint16_t *base;   /* the pattern's frame 0, or the file */
    float (*held)[3]; /* the vertex of each dexel; z = 0: none */
    unsigned n_commits, n_wanted, n_steps, n_resets;
    uint64_t first_frame, last_frame;
} check;

static void load_file(void)
{
    FILE *f = fopen(check.file, "rb");
    size_t n = (size_t)check.width * check.height;

    if (!f || fread(check.base, 2, n, f) != n)
        die("%s: not %zu pixels", check.file, n);
    fclose(f);
}

static int on_stream(void *user, const struct dexel_stream *s)
{
    size_t n = (size_t)s->width * s->height;

    (void)user;
    if (s->model != DEXEL_PINHOLE)
        die("the stream is no pinhole camera");
    check.width = s->width;
    check.height = s->height;
    free(check.base);
    free(check.held);
    check.base = calloc(n, sizeof(*check.base));
    check.held = calloc(n, sizeof(*check.held));
    if (!check.base || !check.held)
        die("out of memory");
    if (check.file)
        load_file();
    else
        for (uint32_t i = 0; i < n; i++)
            check.base[i] = depth_pattern(i % s->width, i / s->width, 0);
    return 0;
}

static int on_reset(void *user, const char *reason)
{
    (void)user;
    fprintf(stderr, "reset: %s\n", reason);
    check.n_resets++;
    return 0;
}

/* A tile has the vertices of its 64 x 64 cells, and so those of the next tiles' first row and
 * column. */
static int on_tile(void *user, const struct dexel_tile *t)
{
    (void)user;
    for (uint32_t row = t->row * 64; row < t->row * 64 + 64 && row < check.height; row++)
        for (uint32_t col = t->col * 64; col < t->col * 64 + 64 && col < check.width; col++)
            memset(check.held[row * check.width + col], 0, sizeof(*check.held));
    for (uint32_t i = 0; i < t->n_vertices; i++)
        memcpy(check.held[t->dexel[i]], t->xyz + 3 * i, sizeof(*check.held));
    return 0;
}

static bool is_near(double a, double b)
{
    return fabs(a - b) <= 1e-5 * (1 + fabs(b));
}

/* Millimetres that dexel `i` must have in a frame that is `step` nearer than the first. */
static unsigned expected_mm(size_t i, unsigned step)
{
    return check.base[i] ? check.base[i] + step : 0;
}

static unsigned step_of_frame(void)
{
    for (size_t i = 0; i < (size_t)check.width * check.height; i++)
        if (check.base[i])
            return (unsigned)lrint(check.held[i][2] * 1000.0) - check.base[i];
    die("no pixel has a depth");
}

static void compare(const struct dexel_commit *c)
{
    unsigned step = step_of_frame();

    if (step >= (check.file ? 1 : DEPTH_PATTERN_STEPS))
        die("frame %llu: the first vertex is at %g m", (unsigned long long)c->frame,
            (double)check.held[0][2]);
    for (size_t i = 0; i < (size_t)check.width * check.height; i++) {
        const float *p = check.held[i];
        unsigned mm = expected_mm(i, step);
        size_t row = i / check.width, col = i % check.width;
        double x = mm * 0.001 * ((double)col - check.cx) / check.fx;
        double y = mm * 0.001 * ((double)row - check.cy) / check.fy;

        if (p[2] != (float)mm * 0.001f || (mm && (!is_near(p[0], x) || !is_near(p[1], y))))
            die("frame %llu, column %zu, row %zu: %.9g %.9g %.9g, expected %.9g %.9g %.9g",
                (unsigned long long)c->frame, i % check.width, i / check.width, (double)p[0],
                (double)p[1], (double)p[2], x, y, mm * 0.001);
    }
}

static int on_commit(void *user, const struct dexel_commit *c)
{
    (void)user;
    compare(c);
    if (check.n_commits == 0)
        check.first_frame = c->frame;
    check.last_frame = c->frame;
    return ++check.n_commits == check.n_wanted ? DONE : 0;
}

int main(int argc, char **argv)
{
    static const struct dexel_callbacks callbacks = {
        .stream = on_stream, .reset = on_reset, .tile = on_tile, .commit = on_commit};
    struct dexel_options options = {.encoding = DEXEL_Q16};
    struct dexel *d;
    int r;

    if (argc != 8 && argc != 9)
        die("usage: depth_check SOCKET STREAM N FX FY CX CY [FILE]");
    options.socket = argv[1];
    options.stream = argv[2];
    check.n_wanted = (unsigned)strtoul(argv[3], NULL, 10);
    check.fx = strtod(argv[4], NULL);
    check.fy = strtod(argv[5], NULL);
    check.cx = strtod(argv[6], NULL);
    check.cy = strtod(argv[7], NULL);
    check.file = argv[8]; /* or NULL */
    r = dexel_open(&d, &options, &callbacks, NULL);
    if (r == 0)
        r = dexel_run(d, SILENCE_MS);
    if (r < 0)
        die("%s", dexel_error(d));
    dexel_close(d);
    printf("%u commits as shown, frames %llu to %llu, %u resets\n", check.n_commits,
           (unsigned long long)check.first_frame, (unsigned long long)check.last_frame,
           check.n_resets);
    return r != DONE;
}
