/* Loading clouds: what is left out, exactness of the lattice, order, neighbours beside an oracle.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "cloud_fixture.h"
#include "core/base/rng.h"
#include "core/cloud/spacing.h"

#include <errno.h>
#include <math.h>

#define N 3000

/* In the unit cube, some of them on a coarse grid: equal distances and equal coordinates. */
static void draw(double *xyz, uint32_t n, uint64_t seed)
{
    struct dx_rng g = dx_rng_init(seed, 0);

    for (uint32_t k = 0; k < 3 * n; k++) {
        xyz[k] = dx_rng_unit(&g);
        if (k / 3 % 2)
            xyz[k] = floor(8 * xyz[k]) / 8;
    }
}

static void every_point_is_there_once(void **state)
{
    double xyz[3 * N];
    bool seen[N] = {false};
    struct dx_cloud c;

    (void)state;
    draw(xyz, N, 1);
    xyz[3 * 5] = NAN;
    xyz[3 * 6 + 1] = INFINITY;
    xyz[3 * 7 + 2] = -INFINITY;
    assert_int_equal(dx_cloud_init(&c, xyz, N, NULL, NULL), 0);
    assert_int_equal(c.n_not_finite, 3);
    assert_true(c.n_duplicates > 0);
    assert_int_equal(c.n + c.n_not_finite + c.n_duplicates, N);
    for (uint32_t r = 0; r < c.n; r++) {
        const uint32_t v = c.index[r];

        assert_true(v < N && !seen[v]);
        seen[v] = true;
        for (int k = 0; k < 3; k++) { /* within half a step of where it was */
            const double x = c.origin[k] + c.step * c.at[r][k];

            assert_true(fabs(x - xyz[3 * v + (uint32_t)c.axis[k]]) <= c.step / 2);
        }
    }
    for (uint32_t v = 0; v < N; v++) /* of duplicates, the first */
        for (uint32_t w = 0;
             w < v && !seen[v] && isfinite(xyz[3 * v] + xyz[3 * v + 1] + xyz[3 * v + 2]); w++)
            if (seen[w] && !memcmp(xyz + 3 * v, xyz + 3 * w, 3 * sizeof(double)))
                seen[v] = true;
    for (uint32_t v = 0; v < N; v++)
        assert_true(seen[v] || (v >= 5 && v <= 7));
    dx_cloud_fini(&c);
}

static void dexels_are_sorted_by_depth(void **state)
{
    double xyz[3 * N];
    struct dx_cloud c;

    (void)state;
    draw(xyz, N, 2);
    assert_int_equal(dx_cloud_init(&c, xyz, N, NULL, NULL), 0);
    assert_int_equal(c.start[c.rows * c.cols], c.n);
    for (uint32_t d = 0; d < c.rows * c.cols; d++)
        for (uint32_t r = c.start[d]; r < c.start[d + 1]; r++) {
            assert_int_equal((uint32_t)(c.at[r][0] / c.side), d / c.cols);
            assert_int_equal((uint32_t)(c.at[r][1] / c.side), d % c.cols);
            assert_true(r == c.start[d] || c.at[r - 1][2] <= c.at[r][2]);
        }
    dx_cloud_fini(&c);
}

/* Also where snapping moves the farthest point on to where a dexel begins. */
static void the_farthest_point_has_a_dexel(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 20000; seed++) {
        struct dx_rng g = dx_rng_init(seed, 8);
        const uint32_t n = 2 + dx_rng_below(&g, 6);
        double xyz[3 * 8];
        struct dx_cloud c;

        draw(xyz, n, seed);
        for (uint32_t k = 0; k < n; k++)
            xyz[3 * k + 1] *= 0x1p-26; /* a few steps wide */
        assert_int_equal(dx_cloud_init(&c, xyz, n, NULL, NULL), 0);
        for (uint32_t r = 0; r < c.n; r++)
            assert_true((uint32_t)(c.at[r][0] / c.side) < c.rows &&
                        (uint32_t)(c.at[r][1] / c.side) < c.cols);
        dx_cloud_fini(&c);
    }
}

static bool is_same_cloud(const struct dx_cloud *a, const struct dx_cloud *b)
{
    return a->n == b->n && !memcmp(a->at, b->at, a->n * sizeof(*a->at)) && a->rows == b->rows &&
           a->cols == b->cols && !memcmp(a->start, b->start, (a->rows * a->cols + 1) * 4u);
}

static void threads_do_not_matter(void **state)
{
    static const unsigned counts[] = {1, 2, 3, 8};
    const uint32_t n = 100000;
    double *xyz = malloc(3 * n * sizeof(*xyz));
    struct dx_cloud first;

    (void)state;
    assert_non_null(xyz);
    draw(xyz, n, 3);
    assert_int_equal(dx_cloud_init(&first, xyz, n, NULL, NULL), 0);
    for (size_t k = 0; k < 4; k++) {
        struct dx_pool *pool;
        struct dx_cloud c;

        assert_int_equal(dx_pool_new(&pool, counts[k]), 0);
        assert_int_equal(dx_cloud_init(&c, xyz, n, pool, NULL), 0);
        assert_true(is_same_cloud(&first, &c));
        assert_memory_equal(first.index, c.index, c.n * sizeof(*c.index));
        dx_cloud_fini(&c);
        dx_pool_free(pool);
    }
    dx_cloud_fini(&first);
    free(xyz);
}

/* Ranks depend on the points, not on the order in which they came. */
static void order_of_input_does_not_matter(void **state)
{
    double xyz[3 * N], back[3 * N];
    struct dx_cloud a, b;

    (void)state;
    draw(xyz, N, 4);
    for (uint32_t k = 0; k < N; k++)
        memcpy(back + 3 * k, xyz + 3 * (N - 1 - k), 3 * sizeof(double));
    assert_int_equal(dx_cloud_init(&a, xyz, N, NULL, NULL), 0);
    assert_int_equal(dx_cloud_init(&b, back, N, NULL, NULL), 0);
    assert_true(is_same_cloud(&a, &b));
    dx_cloud_fini(&a);
    dx_cloud_fini(&b);
}

static int64_t distance2(const struct dx_cloud *c, uint32_t a, uint32_t b)
{
    int64_t d2 = 0;

    for (int k = 0; k < 3; k++)
        d2 += ((int64_t)c->at[a][k] - c->at[b][k]) * ((int64_t)c->at[a][k] - c->at[b][k]);
    return d2;
}

static int by_distance(const void *a, const void *b)
{
    const struct dx_near *x = a, *y = b;

    return x->d2 != y->d2 ? (x->d2 > y->d2) - (x->d2 < y->d2)
                          : (x->rank > y->rank) - (x->rank < y->rank);
}

/* All the others, by distance. */
static void oracle(struct dx_near *all, const struct dx_cloud *c, uint32_t r)
{
    uint32_t n = 0;

    for (uint32_t k = 0; k < c->n; k++)
        if (k != r)
            all[n++] = (struct dx_near){distance2(c, r, k), k};
    qsort(all, n, sizeof(*all), by_distance);
}

static void expect_neighbours(const struct dx_cloud *c, uint32_t r)
{
    static struct dx_near all[N], found[N];
    const uint32_t n = c->n - 1;

    oracle(all, c, r);
    for (uint32_t k = 1; k <= DX_CLOUD_MAX_NEAREST; k += 9) {
        assert_int_equal(dx_cloud_nearest(c, r, k, found), k < n ? k : n);
        for (uint32_t i = 0; i < k && i < n; i++)
            assert_true(found[i].rank == all[i].rank && found[i].d2 == all[i].d2);
    }
    for (uint32_t k = 0; k < n; k += n / 3 + 1) {
        const int32_t radius = (int32_t)sqrt((double)all[k].d2) + (int32_t)(r % 2);
        uint32_t want = 0, got = dx_cloud_within(c, c->at[r], radius, found, N);

        while (want < n && all[want].d2 <= (int64_t)radius * radius)
            want++;
        assert_int_equal(got, want + 1); /* and itself */
        qsort(found, got, sizeof(*found), by_distance);
        assert_int_equal(found[0].rank, r);
        for (uint32_t i = 0; i < want; i++)
            assert_int_equal(found[i + 1].rank, all[i].rank);
    }
}

static void neighbours_are_those_of_brute_force(void **state)
{
    double xyz[3 * N];
    struct dx_cloud c;

    (void)state;
    for (uint64_t seed = 0; seed < 6; seed++) {
        uint32_t n = seed < 2 ? 20 : 600 * (uint32_t)seed / 2;

        draw(xyz, n, seed);
        for (uint32_t k = 0; k < n && seed > 3; k++) { /* a plate; a needle of clusters */
            xyz[3 * k + 1] *= 1e-3;
            xyz[3 * k + 2] = seed == 5 ? 0 : xyz[3 * k + 2];
        }
        assert_int_equal(dx_cloud_init(&c, xyz, n, NULL, NULL), 0);
        for (uint32_t r = 0; r < c.n; r += 7)
            expect_neighbours(&c, r);
        dx_cloud_fini(&c);
    }
}

static void spacing_is_found(void **state)
{
    double xyz[3 * 2500];
    struct dx_cloud c;

    (void)state;
    for (uint32_t k = 0; k < 2500; k++) {
        const uint32_t row = k / 50, col = k % 50;

        xyz[3 * k] = 0.25 * col;
        xyz[3 * k + 1] = 1e6 + 0.25 * row;
        xyz[3 * k + 2] = -4;
    }
    assert_int_equal(dx_cloud_init(&c, xyz, 2500, NULL, NULL), 0);
    assert_true(fabs(dx_cloud_spacing(&c) * c.step - 0.25) < 1e-6);
    dx_cloud_fini(&c);
}

/* On a curved surface: its bend is not taken for noise. */
static void noise_is_found(void **state)
{
    static const double noises[] = {0, 0.1, 0.5};

    (void)state;
    for (size_t k = 0; k < 3; k++) {
        const struct dx_surface_config config = {DX_SURFACE_TORUS, 20000, 0.3, noises[k], 0, 11};
        struct dx_surface_points p;
        struct dx_cloud c;
        double noise;

        assert_int_equal(dx_surface_sample(&p, &config), 0);
        assert_int_equal(dx_cloud_init(&c, p.xyz, p.n, NULL, NULL), 0);
        noise = dx_cloud_noise(&c) * c.step / p.spacing;
        assert_true(noise > 0.7 * noises[k] && noise < 1.3 * noises[k] + 0.01);
        dx_cloud_fini(&c);
        free(p.xyz);
    }
}

static void few_points_are_a_cloud(void **state)
{
    const double xyz[] = {1, 2, 3, 1, 2, 3, NAN, 0, 0, 1, 2, 3};
    const double far[] = {0, 0, 0, 1e200, 0, 0};
    struct dx_near near[4];
    struct dx_err err;
    struct dx_cloud c;

    (void)state;
    assert_int_equal(dx_cloud_init(&c, NULL, 0, NULL, NULL), 0);
    assert_int_equal(c.n, 0);
    assert_int_equal(dx_cloud_within(&c, (int32_t[3]){0}, 5, near, 4), 0);
    dx_cloud_fini(&c);
    assert_int_equal(dx_cloud_init(&c, xyz + 6, 1, NULL, NULL), 0);
    assert_int_equal(c.n + c.n_not_finite, 1);
    dx_cloud_fini(&c);
    assert_int_equal(dx_cloud_init(&c, xyz, 4, NULL, NULL), 0);
    assert_int_equal(c.n, 1);
    assert_int_equal(c.n_duplicates, 2);
    assert_int_equal(c.index[0], 0);
    assert_int_equal(dx_cloud_nearest(&c, 0, 3, near), 0);
    dx_cloud_fini(&c);
    assert_int_equal(dx_cloud_init(&c, far, 2, NULL, &err), -ERANGE);
    assert_non_null(strstr(err.text, "beyond"));
    assert_int_equal(dx_cloud_init(&c, xyz, DX_CLOUD_MAX_POINTS + 1, NULL, &err), -EFBIG);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_point_is_there_once),
        cmocka_unit_test(dexels_are_sorted_by_depth),
        cmocka_unit_test(the_farthest_point_has_a_dexel),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(order_of_input_does_not_matter),
        cmocka_unit_test(neighbours_are_those_of_brute_force),
        cmocka_unit_test(spacing_is_found),
        cmocka_unit_test(noise_is_found),
        cmocka_unit_test(few_points_are_a_cloud),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
