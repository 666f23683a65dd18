/* Rows of points are those of dx_geometry_point to the bit, across the seam and past the ends. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "core/base/bytes.h"
#include "core/grid/strip.h"
#include "terrain_rig.h"

static void assert_row(struct dx_strip *s, uint32_t row, int64_t col0, struct dx_rng *rng)
{
    const struct dx_geometry *g = s->geometry;
    uint32_t range[DX_ROWS_N];
    float r[DX_ROWS_N];
    struct dx_row_points p;

    for (uint32_t j = 0; j < DX_ROWS_N; j++) {
        range[j] = (uint32_t)(dx_rng_u64(rng) >> (32 + dx_rng_below(rng, 32)));
        r[j] = (float)range[j] * g->unit_m;
    }
    dx_strip_points(&p, s, row, r);
    for (uint32_t j = 0; j < DX_ROWS_N; j++) {
        const int64_t col = col0 + j, width = g->width;
        float want[3];

        if (!g->wrap && (col < 0 || col >= width)) {
            assert_int_equal(s->col[j], -1);
            continue;
        }
        assert_int_equal(s->col[j], (col % width + width) % width);
        dx_geometry_point(g, row, (uint32_t)s->col[j], range[j], want);
        assert_int_equal(dx_f32_bits(p.x[j]), dx_f32_bits(want[0]));
        assert_int_equal(dx_f32_bits(p.y[j]), dx_f32_bits(want[1]));
        assert_int_equal(dx_f32_bits(p.z[j]), dx_f32_bits(want[2]));
    }
}

/* As many columns follow each other as are promised, and the next one does not follow. */
static void assert_runs(const struct dx_strip *s)
{
    for (uint32_t j = 0; j < DX_ROWS_N; j++) {
        const uint32_t end = j + s->n_next[j];

        if (s->col[j] < 0)
            continue;
        assert_in_range(end, j + 1, DX_ROWS_N);
        for (uint32_t k = j + 1; k < end; k++)
            assert_int_equal(s->col[k], s->col[k - 1] + 1);
        assert_true(end == DX_ROWS_N || s->col[end] != s->col[end - 1] + 1);
    }
}

static void rows_are_those_of_the_geometry(void **state)
{
    struct dx_rng rng = dx_rng_init(43, 0);

    (void)state;
    for (int k = 0; k < 300; k++) {
        struct dx_geometry *g = any_geometry(&rng, 2 + dx_rng_below(&rng, 5),
                                             2 + dx_rng_below(&rng, k % 2 ? 20 : 200), 4);
        const int64_t col0 = (int64_t)dx_rng_below(&rng, g->width + 10) - 10;
        struct dx_strip s;

        for (uint32_t m = 0; g->model == DX_MODEL_SPINNING && m < 6 * g->height; m++)
            g->table[2 * g->width + m] += 0.01f * (float)dx_rng_unit(&rng); /* origins too */
        dx_strip_init(&s, g, dx_rows_get(DX_SIMD_AUTO), col0);
        assert_runs(&s);
        for (uint32_t i = 0; i < g->height; i++)
            assert_row(&s, i, col0, &rng);
        dx_geometry_unref(g);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_are_those_of_the_geometry),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
