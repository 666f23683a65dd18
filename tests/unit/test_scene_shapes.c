/* The shapes of particular scenes: what moves, and what is a dexel wide. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "tests/unit/scene_rig.h"

#include <math.h>
#include <stdlib.h>

/* Tiles of 64 x 64 that differ between two frames, in percent of all. */
static double changed_tiles(const struct rig *a, const struct rig *b)
{
    uint32_t rows = (a->g->height + 63) / 64, cols = (a->g->width + 63) / 64, n = 0;
    bool *changed = calloc(rows * cols, sizeof(*changed));

    assert_non_null(changed);
    for (size_t k = 0; k < dx_plane_n_dexels(&a->plane); k++)
        if (dx_plane_range(&a->plane, k) != dx_plane_range(&b->plane, k))
            changed[k / a->g->width / 64 * cols + k % a->g->width / 64] = true;
    for (uint32_t k = 0; k < rows * cols; k++)
        n += changed[k];
    free(changed);
    return 100.0 * n / (rows * cols);
}

static void the_box_moves_and_comes_back(void **state)
{
    double sum = 0;
    struct rig a, b;

    (void)state;
    rig_init(&a, DX_SCENE_MOVING_BOX, 480, 640);
    b = a;
    rig_open(&a);
    rig_open(&b);
    assert_int_equal(a.g->model, DX_MODEL_PINHOLE);
    for (uint64_t k = 0; k < 120; k += 8) {
        double percent;

        rig_cast(&a, k);
        rig_cast(&b, k + 1);
        percent = changed_tiles(&a, &b);
        assert_true(percent >= 1 && percent <= 12);
        sum += percent;
    }
    assert_true(sum / 15 >= 2 && sum / 15 <= 10);
    rig_cast(&a, 7);
    rig_cast(&b, 127);
    assert_true(same(&a.plane, &b.plane));
    rig_close(&a);
    rig_close(&b);
}

static uint32_t near_run(const struct rig *r, uint32_t row, uint32_t col)
{
    uint32_t n = 0;

    while (col + n < r->g->width && truth(r, 0, row, col + n) < 5)
        n++;
    return n;
}

static void poles_are_one_to_three_dexels_wide(void **state)
{
    uint32_t seen[4] = {0}, row = 200;
    struct rig r;

    (void)state;
    rig_init(&r, DX_SCENE_POLES, 400, 600);
    rig_open(&r);
    for (uint32_t col = 0; col < 600;) {
        uint32_t wide = near_run(&r, row, col);

        assert_in_range(wide, 0, 3);
        seen[wide]++;
        col += wide + 1;
    }
    assert_true(seen[1] == 8 && seen[2] == 8 && seen[3] == 8);
    rig_close(&r);
}

static void pickets_alternate(void **state)
{
    struct rig r;

    (void)state;
    rig_init(&r, DX_SCENE_FENCE, 100, 333);
    rig_open(&r);
    for (uint32_t col = 0; col < 333; col++)
        assert_true((truth(&r, 0, 50, col) < 3.1) == (col % 2 == 0));
    rig_close(&r);
}

/* The crease: the range's second difference along a row stands out at a column that moves with the
 * row. */
static void the_crease_leans(void **state)
{
    double at[2];
    struct rig r;

    (void)state;
    rig_init(&r, DX_SCENE_CREASE, 400, 600);
    rig_open(&r);
    for (int k = 0; k < 2; k++) {
        uint32_t row = k ? 300 : 100, best = 0;
        double top = -INFINITY;

        for (uint32_t col = 0; col < 600; col++)
            if (truth(&r, 0, row, col) > top) {
                top = truth(&r, 0, row, col);
                best = col;
            }
        at[k] = best;
    }
    /* 200 rows of 0.1 degrees at 0.1 degrees a column: tan 17 = 0.306 columns a row */
    assert_true(fabs((at[1] - at[0]) / 200 - 0.306) < 0.02);
    rig_close(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_box_moves_and_comes_back),
        cmocka_unit_test(poles_are_one_to_three_dexels_wide),
        cmocka_unit_test(pickets_alternate),
        cmocka_unit_test(the_crease_leans),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
