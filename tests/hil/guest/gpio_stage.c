/*
 * gpio_stage CHIP FOLDER: turns a simulated stage by its encoder's lines 0 and 1 of a chip, with an
 * index on the line named encoder-index (2), and holds the driver's encoder to it: every count, the
 * index both ways, the angle, no doubt; and a doubt when edges are withheld.
 */
#include "core/base/trig.h"
#include "drivers/angle.h"
#include "drivers/gpio/line_thread.h"
#include "drivers/monotonic.h"
#include "drivers/stage_encoder.h"
#include "tests/hil/guest/sim_lines.h"

#include <math.h>

#define COUNTS 40
#define WIDTH  3 /* counts that the index is high */

static struct dx_angle_source *source;
static uint64_t n_edges;

static struct dx_encoder_status await_edges(void)
{
    struct dx_encoder_status s;

    for (int tries = 0; tries < SIM_TRIES; tries++) {
        dx_encoder_tell(source, &s);
        if (s.n_edges == n_edges)
            return s;
        poll(NULL, 0, 1);
    }
    fprintf(stderr, "%llu edges, expected %llu\n", (unsigned long long)s.n_edges,
            (unsigned long long)n_edges);
    exit(1);
}

/* From count `at` on by `n`, up or down; returns where it is then. */
static int turn(int at, int n)
{
    static const bool a[4] = {false, true, true, false}, b[4] = {false, false, true, true};
    int step = n < 0 ? -1 : 1;

    for (int k = 0; k != n; k += step) {
        int next = at + step;
        bool z = ((next % COUNTS) + COUNTS) % COUNTS < WIDTH;
        bool was_z = ((at % COUNTS) + COUNTS) % COUNTS < WIDTH;

        if (a[next & 3] != a[at & 3])
            sim_pull(0, a[next & 3]);
        else
            sim_pull(1, b[next & 3]);
        if (z != was_z)
            sim_pull(2, z);
        n_edges += z != was_z ? 2 : 1;
        at = next;
        if (k % 8 == 0) /* the kernel keeps sixteen of each line */
            await_edges();
    }
    return at;
}

static void expect_angle(double turns)
{
    struct dx_angle_sample s[2];
    uint64_t now = dx_clock_ns();

    poll(NULL, 0, 5); /* libgpiod 1 has to wait before it knows that no edge has come */
    expect(source->ops->samples(source, now, now, s, 2) == 1, "the angle is known");
    expect(!s[0].uncertain, "the angle is certain");
    if (fabs(s[0].angle_rad / (2 * DX_PI) - turns) > 1.01 / COUNTS)
        die("angle", "more than a count off");
}

int main(int argc, char **argv)
{
    char a[64], b[64], z[] = "encoder-index", text[96];
    struct dx_encoder_config config = {.a = a, .b = b, .z = z, .counts = COUNTS, .gear = 1};
    struct dx_encoder_status s;
    struct dx_err err = {""};
    int at;

    if (argc != 3)
        die("gpio_stage", "CHIP FOLDER");
    sim_folder = argv[2];
    snprintf(a, sizeof(a), "%s:0", argv[1]);
    snprintf(b, sizeof(b), "/dev/%s:1", argv[1]);
    if (dx_encoder_open(&source, &config, &err))
        die("open", err.text);
    at = turn(4, 100); /* count 4: A and B low, and beside the index */
    s = await_edges();
    printf("%llu edges up: count %lld, index %llu times\n", (unsigned long long)s.n_edges,
           (long long)s.count, (unsigned long long)s.n_index);
    expect(s.n_doubts == 0 && s.n_mismatch == 0, "no edge is missed");
    expect(s.n_index == 2, "two turns began");
    expect(((s.count - at) % COUNTS + COUNTS) % COUNTS <= 1, "the count is from the index");
    expect_angle((double)s.count / COUNTS);
    at = turn(at, -70);
    s = await_edges();
    expect(s.n_doubts == 0 && s.n_mismatch == 0, "no edge is missed on the way back");
    expect(s.n_index == 4, "two turns ended");
    source->ops->trouble(source, text, sizeof(text));
    expect(!*text, "no trouble");
    expect_angle((double)s.count / COUNTS);
    sim_pull(3, true); /* no line of ours */
    at = turn(at, 10);
    s = await_edges();
    expect(!s.is_uncertain, "certain");
    printf("back and on again: count %lld at %d\n", (long long)s.count, at);
    dx_angle_close(source);
    return 0;
}
