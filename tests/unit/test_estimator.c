/*
 * The filters over frames: what they do to stray samples, surfaces that move, gaps; and that their
 * integers are the plain rules, by an oracle that divides where they multiply.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "core/grid/estimator.h"

#include <string.h>

#define HEIGHT 3
#define WIDTH  70

/* An estimator of its own, with a plane to take frames from. */
struct rig {
    struct dx_estimator e;
    struct dx_plane frame;
    struct dx_sigma sigma;
    uint64_t estimate[HEIGHT][WIDTH];
};

/* sigma0 in units. */
static void rig_open(struct rig *r, const struct dx_ingest_params *params, uint8_t range_bytes,
                     double sigma0)
{
    const double sigma[3] = {sigma0 * 1e-3, 2e-4, 1e-6};

    assert_int_equal(dx_plane_init(&r->frame, HEIGHT, WIDTH, range_bytes, 1), 0);
    assert_int_equal(dx_estimator_init(&r->e, params, &r->frame, dx_rows_get(DX_SIMD_AUTO)), 0);
    dx_sigma_init(&r->sigma, sigma, 1e-3);
    dx_estimator_settle(&r->e, &r->sigma);
}

static void rig_close(struct rig *r)
{
    dx_estimator_fini(&r->e);
    dx_plane_fini(&r->frame);
}

static void take_columns(struct rig *r, uint32_t col0, uint32_t n)
{
    struct dx_estimates out;

    dx_estimator_begin(&r->e, &r->frame, col0, n);
    for (uint32_t i = 0; i < HEIGHT; i++) {
        dx_estimator_take(&r->e, &r->frame, i, col0, n, &out);
        for (uint32_t k = 0; k < n; k++) {
            r->estimate[i][col0 + k] = dx_estimate_at(&out, k);
            assert_int_equal(out.range[k], (r->estimate[i][col0 + k] + 128) >> 8);
        }
    }
}

/* The same range everywhere; the estimate in units, rounded down. */
static uint32_t take(struct rig *r, uint32_t range)
{
    for (size_t k = 0; k < dx_plane_n_dexels(&r->frame); k++)
        dx_plane_set_range(&r->frame, k, range);
    take_columns(r, 0, WIDTH);
    assert_true(r->estimate[0][0] == r->estimate[HEIGHT - 1][WIDTH - 1]);
    return (uint32_t)(r->estimate[0][0] >> DX_ESTIMATE_FRACTION);
}

static struct dx_ingest_params mean_of(uint32_t n_max)
{
    return (struct dx_ingest_params){.filter = DX_FILTER_MEAN, .n_max = n_max, .n_gap = 2};
}

/* ---- the oracle ----------------------------------------------------------------------------- */

struct plain {
    int64_t est, alt; /* 1/256 unit */
    int64_t n, alt_n, missing, astray;
};

/* d / n, the half rounded up. */
static int64_t divided(int64_t d, int64_t n)
{
    int64_t a = 2 * d + n, b = 2 * n, q = a / b;

    return q - (a % b != 0 && a < 0);
}

static bool near(const struct rig *r, int64_t z, int64_t h)
{
    int64_t d = z > h ? z - h : h - z;

    return d <= 4 * (int64_t)dx_sigma_at(&r->sigma, (uint32_t)(h / 256));
}

static void plain_contradict(struct plain *p, const struct rig *r, int64_t z, int64_t n_max)
{
    bool confirmed = p->alt_n && near(r, z, p->alt);

    p->alt_n = confirmed ? p->alt_n + 1 : 1;
    p->alt = confirmed ? p->alt + divided(z - p->alt, p->alt_n) : z;
    p->astray++;
    if (p->alt_n == 2)
        *p = (struct plain){.est = p->alt, .n = n_max < 2 ? n_max : 2};
    else if (p->n == 1 || p->astray == 3)
        *p = (struct plain){.est = z, .n = 1};
}

static int64_t plain_take(struct plain *p, const struct rig *r, uint32_t range,
                          const struct dx_ingest_params *params)
{
    int64_t z = 256 * (int64_t)range;

    if (range == 0) {
        if (p->est && ++p->missing > (int64_t)params->n_gap)
            *p = (struct plain){0};
    } else if (range >= 1u << 24 || p->est == 0 || p->est >= 1ll << 32) {
        *p = (struct plain){.est = z, .n = 1};
    } else if (near(r, z, p->est)) {
        p->n += p->n < params->n_max;
        p->est += divided(z - p->est, p->n);
        p->alt_n = p->missing = p->astray = 0;
    } else {
        plain_contradict(p, r, z, params->n_max);
    }
    return p->est;
}

/* Mostly one of a few surfaces with noise, also gaps, strays and ends of the scale. */
static uint32_t any_range(struct dx_rng *rng, uint32_t range_bytes)
{
    uint32_t top = range_bytes == 2 ? 65535 : (1u << 24) + 3;

    switch (dx_rng_below(rng, 12)) {
    case 0:
    case 1:
        return 0;
    case 2:
        return 1 + dx_rng_below(rng, top);
    case 3:
        return top - dx_rng_below(rng, 6);
    case 4:
        return 1 + dx_rng_below(rng, 6);
    default:
        return 5000 + 3000 * dx_rng_below(rng, 2) + dx_rng_below(rng, 60);
    }
}

static void the_mean_equals_the_plain_rules(void **state)
{
    struct dx_rng rng = dx_rng_init(5, 0);

    (void)state;
    for (int round = 0; round < 60; round++) {
        struct dx_ingest_params params = mean_of(round % 4 ? 1 + dx_rng_below(&rng, 255) : 16);
        static struct plain plain[HEIGHT][WIDTH];
        struct rig r;

        memset(plain, 0, sizeof(plain));
        params.n_gap = dx_rng_below(&rng, 5);
        rig_open(&r, &params, round & 1 ? 4 : 2, round % 7 == 6 ? 3e5 : 1 + round % 9);
        for (int frame = 0; frame < 60; frame++) {
            uint32_t col0 = dx_rng_below(&rng, WIDTH), n = 1 + dx_rng_below(&rng, WIDTH - col0);

            for (size_t k = 0; k < dx_plane_n_dexels(&r.frame); k++)
                dx_plane_set_range(&r.frame, k, any_range(&rng, r.frame.range_bytes));
            take_columns(&r, col0, n);
            for (uint32_t i = 0; i < HEIGHT; i++)
                for (uint32_t j = col0; j < col0 + n; j++)
                    assert_true(r.estimate[i][j] ==
                                (uint64_t)plain_take(
                                    &plain[i][j], &r,
                                    dx_plane_range(&r.frame, (size_t)i * WIDTH + j), &params));
        }
        rig_close(&r);
    }
}

/* ---- what the rules do ---------------------------------------------------------------------- */

static void the_mean_is_the_mean(void **state)
{
    struct dx_ingest_params params = mean_of(16);
    struct rig r;

    (void)state;
    rig_open(&r, &params, 2, 5);
    take(&r, 1000);
    take(&r, 1001);
    take(&r, 1004);
    assert_int_equal(take(&r, 1007), 1003);
    assert_int_equal(r.estimate[0][0], 1003 * 256);
    rig_close(&r);
}

static void a_stray_sample_changes_nothing(void **state)
{
    struct dx_ingest_params params = mean_of(16);
    struct rig r;

    (void)state;
    rig_open(&r, &params, 2, 5);
    take(&r, 5000);
    take(&r, 5000);
    for (int k = 0; k < 5; k++) {
        assert_int_equal(take(&r, 3000 + 100 * (uint32_t)k), 5000);
        assert_int_equal(take(&r, 5000), 5000);
    }
    rig_close(&r);
}

static void what_has_moved_is_followed_with_the_second_frame(void **state)
{
    struct dx_ingest_params params = mean_of(16);
    struct rig r;

    (void)state;
    rig_open(&r, &params, 2, 5);
    for (int k = 0; k < 20; k++)
        take(&r, 5000);
    assert_int_equal(take(&r, 3000), 5000);
    assert_int_equal(take(&r, 3002), 3001);
    assert_int_equal(take(&r, 3004), 3002); /* a mean of three: the old samples are gone */
    rig_close(&r);
}

/* Each frame contradicts the one before, so nothing is ever confirmed; the surface must not freeze.
 */
static void what_keeps_moving_is_followed(void **state)
{
    struct dx_ingest_params params = mean_of(16);
    struct rig r;

    (void)state;
    rig_open(&r, &params, 2, 5);
    for (int k = 0; k < 20; k++)
        take(&r, 5000);
    assert_int_equal(take(&r, 4900), 5000);
    assert_int_equal(take(&r, 4800), 5000);
    for (uint32_t range = 4700; range > 3000; range -= 100)
        assert_int_equal(take(&r, range), range);
    rig_close(&r);
}

static void gaps_are_bridged(void **state)
{
    struct dx_ingest_params params = mean_of(16);
    struct rig r;

    (void)state;
    for (params.n_gap = 0; params.n_gap < 4; params.n_gap++) {
        rig_open(&r, &params, 2, 5);
        take(&r, 5000);
        for (int round = 0; round < 3; round++) {
            for (uint32_t k = 0; k < params.n_gap; k++)
                assert_int_equal(take(&r, 0), 5000);
            assert_int_equal(take(&r, 5000), 5000); /* and the count begins anew */
        }
        for (uint32_t k = 0; k < params.n_gap; k++)
            assert_int_equal(take(&r, 0), 5000);
        assert_int_equal(take(&r, 0), 0);
        assert_int_equal(take(&r, 5010), 5010);
        rig_close(&r);
    }
}

static void far_ranges_are_taken_as_they_come(void **state)
{
    struct dx_ingest_params params = mean_of(16);
    struct rig r;

    (void)state;
    rig_open(&r, &params, 4, 5);
    assert_int_equal(take(&r, 0xfffffff0), 0xfffffff0);
    assert_int_equal(take(&r, 0xffffffff), 0xffffffff);
    assert_int_equal(take(&r, 0), 0xffffffff);
    assert_int_equal(take(&r, 1u << 24), 1u << 24);
    assert_int_equal(take(&r, (1u << 24) - 1), (1u << 24) - 1);
    assert_int_equal(take(&r, 5000), 5000);
    assert_int_equal(take(&r, 5002), 5001);
    assert_int_equal(take(&r, 1u << 24), 1u << 24);
    rig_close(&r);
}

static uint32_t middle(uint32_t a, uint32_t b, uint32_t c)
{
    if ((a >= b && a <= c) || (a <= b && a >= c))
        return a;
    return (b >= a && b <= c) || (b <= a && b >= c) ? b : c;
}

static void the_median_is_of_three_frames(void **state)
{
    struct dx_ingest_params params = {.filter = DX_FILTER_MEDIAN3};
    struct dx_rng rng = dx_rng_init(9, 0);

    (void)state;
    for (uint8_t bytes = 2; bytes <= 4; bytes += 2) {
        uint32_t last[3] = {0};
        struct rig r;

        rig_open(&r, &params, bytes, 5);
        for (int frame = 0; frame < 500; frame++) {
            uint32_t z = any_range(&rng, bytes);

            last[2] = frame ? last[1] : z;
            last[1] = frame ? last[0] : z;
            last[0] = z;
            assert_int_equal(take(&r, z), middle(last[0], last[1], last[2]));
        }
        take(&r, 0);
        take(&r, 4000);
        assert_int_equal(take(&r, 4010), 4000); /* one missing: the nearer of the others */
        take(&r, 0);
        assert_int_equal(take(&r, 0), 0);
        rig_close(&r);
    }
}

static void filters_give_the_same_in_16_and_32_bits(void **state)
{
    struct dx_rng rng = dx_rng_init(3, 0);

    (void)state;
    for (enum dx_filter filter = DX_FILTER_OFF; filter <= DX_FILTER_MEDIAN3; filter++) {
        struct dx_ingest_params params = {.filter = filter, .n_max = 16, .n_gap = 2};
        struct rig narrow, wide;

        rig_open(&narrow, &params, 2, 5);
        rig_open(&wide, &params, 4, 5);
        for (int frame = 0; frame < 40; frame++) {
            for (size_t k = 0; k < dx_plane_n_dexels(&wide.frame); k++) {
                dx_plane_set_range(&narrow.frame, k, any_range(&rng, 2));
                dx_plane_set_range(&wide.frame, k, dx_plane_range(&narrow.frame, k));
            }
            take_columns(&narrow, 0, WIDTH);
            take_columns(&wide, 0, WIDTH);
            assert_memory_equal(narrow.estimate, wide.estimate, sizeof(wide.estimate));
        }
        rig_close(&narrow);
        rig_close(&wide);
    }
}

/* Without the noise nothing tells a stray sample from another one. */
static void until_the_noise_is_known_samples_are_taken_as_they_come(void **state)
{
    struct dx_ingest_params params = mean_of(16);
    struct rig r;

    (void)state;
    rig_open(&r, &params, 2, 5);
    r.e.settled = false;
    assert_int_equal(take(&r, 5000), 5000);
    assert_int_equal(take(&r, 5002), 5002);
    assert_int_equal(take(&r, 60000), 60000);
    assert_int_equal(take(&r, 0), 60000);
    dx_estimator_settle(&r.e, &r.sigma);
    assert_int_equal(take(&r, 60002), 60001);
    rig_close(&r);
}

static void what_is_forgotten_is_not_averaged(void **state)
{
    (void)state;
    for (enum dx_filter filter = DX_FILTER_MEAN; filter <= DX_FILTER_MEDIAN3; filter++) {
        struct dx_ingest_params params = {.filter = filter, .n_max = 16, .n_gap = 2};
        struct rig r;

        rig_open(&r, &params, 2, 5);
        for (int k = 0; k < 5; k++)
            take(&r, 5000);
        dx_estimator_forget(&r.e);
        assert_int_equal(take(&r, 5010), 5010);
        dx_estimator_forget(&r.e);
        assert_int_equal(take(&r, 0), 0);
        rig_close(&r);
    }
}

static void attributes_are_those_of_the_newest_returns(void **state)
{
    (void)state;
    for (enum dx_filter filter = DX_FILTER_MEAN; filter <= DX_FILTER_MEDIAN3; filter++) {
        struct dx_ingest_params params = {.filter = filter, .n_max = 16, .n_gap = 2};
        struct rig r;

        rig_open(&r, &params, 2, 5);
        dx_plane_set_attr(&r.frame, 7, 10);
        take(&r, 5000);
        dx_plane_set_attr(&r.frame, 7, 20);
        take(&r, 3000); /* stray, but a return */
        assert_int_equal(dx_plane_attr(&r.e.newest, 7), 20);
        dx_plane_set_attr(&r.frame, 7, 30);
        take(&r, 0);
        assert_int_equal(dx_plane_attr(&r.e.newest, 7), 20);
        rig_close(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_mean_equals_the_plain_rules),
        cmocka_unit_test(the_mean_is_the_mean),
        cmocka_unit_test(a_stray_sample_changes_nothing),
        cmocka_unit_test(what_has_moved_is_followed_with_the_second_frame),
        cmocka_unit_test(what_keeps_moving_is_followed),
        cmocka_unit_test(gaps_are_bridged),
        cmocka_unit_test(far_ranges_are_taken_as_they_come),
        cmocka_unit_test(the_median_is_of_three_frames),
        cmocka_unit_test(filters_give_the_same_in_16_and_32_bits),
        cmocka_unit_test(until_the_noise_is_known_samples_are_taken_as_they_come),
        cmocka_unit_test(what_is_forgotten_is_not_averaged),
        cmocka_unit_test(attributes_are_those_of_the_newest_returns),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
