/* Rings: chains grow, join and close; what does not fit is refused; memory follows what is in use.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/base/rng.h"
#include "core/cloud/point_ring.h"

#include <string.h>

static void expect_list(const struct dx_rings *r, uint32_t ring, const char *want)
{
    char text[256] = "";
    size_t len = 0;

    for (uint32_t k = 0; k < dx_ring_n(r, ring); k++) {
        const uint32_t v = dx_ring_list(r, ring)[k];

        if (v & DX_RING_FIRST)
            text[len++] = '|';
        text[len++] = (char)('a' + (v & ~DX_RING_FIRST));
        text[len] = 0;
    }
    assert_string_equal(text, want);
}

static int add(struct dx_rings *r, uint32_t *ring, char a, char b)
{
    assert_true(dx_ring_fits(r, *ring, (uint32_t)(a - 'a'), (uint32_t)(b - 'a')));
    return dx_ring_add(r, ring, (uint32_t)(a - 'a'), (uint32_t)(b - 'a'));
}

static bool fits(const struct dx_rings *r, uint32_t ring, char a, char b)
{
    return dx_ring_fits(r, ring, (uint32_t)(a - 'a'), (uint32_t)(b - 'a'));
}

static void chains_grow_and_join(void **state)
{
    struct dx_rings r;
    uint32_t ring = 0;

    (void)state;
    dx_rings_init(&r);
    assert_int_equal(add(&r, &ring, 'a', 'b'), DX_RING_OPEN);
    add(&r, &ring, 'b', 'c');
    expect_list(&r, ring, "|abc");
    add(&r, &ring, 'f', 'a');
    expect_list(&r, ring, "|fabc");
    add(&r, &ring, 'd', 'e');
    expect_list(&r, ring, "|fabc|de");
    assert_false(fits(&r, ring, 'a', 'c')); /* from a there is a triangle */
    assert_false(fits(&r, ring, 'd', 'a')); /* to a as well */
    assert_false(fits(&r, ring, 'c', 'f')); /* closes, and d-e would remain */
    add(&r, &ring, 'e', 'f');
    expect_list(&r, ring, "|defabc");
    assert_true(fits(&r, ring, 'c', 'd'));
    assert_int_equal(add(&r, &ring, 'c', 'd'), DX_RING_CLOSED);
    dx_ring_free(&r, &ring);
    assert_int_equal(ring, 0);
    assert_int_equal(r.n_used, 0);
    assert_int_equal(r.n_peak, 1);
    dx_rings_fini(&r);
}

static void the_back_of_a_triangle_does_not_fit(void **state)
{
    struct dx_rings r;
    uint32_t ring = 0;

    (void)state;
    dx_rings_init(&r);
    add(&r, &ring, 'a', 'b');
    assert_false(fits(&r, ring, 'b', 'a'));
    dx_rings_fini(&r);
}

/* Around a point of many neighbours, in any order; others come and go beside it. */
static void any_order_closes(void **state)
{
    struct dx_rng g = dx_rng_init(1, 2);

    (void)state;
    for (uint32_t n = 3; n <= 250; n += 13) {
        uint32_t order[256] = {0}, ring = 0, beside = 0;
        struct dx_rings r;

        dx_rings_init(&r);
        for (uint32_t k = 0; k < n; k++) {
            uint32_t j = dx_rng_below(&g, k + 1);

            order[k] = order[j];
            order[j] = k;
        }
        for (uint32_t k = 0; k < n; k++) {
            const uint32_t a = order[k], b = (order[k] + 1) % n;

            assert_true(dx_ring_fits(&r, ring, a, b));
            assert_int_equal(dx_ring_add(&r, &ring, a, b),
                             k + 1 == n ? DX_RING_CLOSED : DX_RING_OPEN);
            assert_true(k + 1 == n || !dx_ring_fits(&r, ring, a, b));
            dx_ring_free(&r, &beside);
            assert_int_equal(dx_ring_add(&r, &beside, 1, 2), DX_RING_OPEN);
        }
        assert_int_equal(dx_ring_n(&r, ring), n);
        for (uint32_t k = 1; k < n; k++)
            assert_int_equal(dx_ring_list(&r, ring)[k],
                             ((dx_ring_list(&r, ring)[k - 1] & ~DX_RING_FIRST) + 1) % n);
        assert_true(r.peak_len < 4096); /* n at most, each size once, and the one beside */
        dx_rings_fini(&r);
    }
}

static void too_many_neighbours_do_not_fit(void **state)
{
    struct dx_rings r;
    uint32_t ring = 0, k = 0;

    (void)state;
    dx_rings_init(&r);
    while (dx_ring_fits(&r, ring, k, k + 1)) {
        assert_int_equal(dx_ring_add(&r, &ring, k, k + 1), DX_RING_OPEN);
        k++;
    }
    assert_in_range(dx_ring_n(&r, ring), DX_RING_MAX - 2, DX_RING_MAX);
    dx_rings_fini(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chains_grow_and_join),
        cmocka_unit_test(the_back_of_a_triangle_does_not_fit),
        cmocka_unit_test(any_order_closes),
        cmocka_unit_test(too_many_neighbours_do_not_fit),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
