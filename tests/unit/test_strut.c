/* Strut codes: every one of them decoded and drawn in the index plane. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "core/grid/strut.h"

struct point {
    int along, across;
};

static bool same(struct point a, struct point b)
{
    return a.along == b.along && a.across == b.across;
}

/* As along and across the strut. */
static struct point corner(const struct dx_strut *s, struct dx_strut_corner c)
{
    return s->across ? (struct point){c.col, c.row} : (struct point){c.row, c.col};
}

/* Twice the area; positive when it runs as a cell's abc: (0,0), (0,1), (1,1). */
static int area2(const struct dx_strut_corner t[3])
{
    return (t[1].col - t[0].col) * (t[2].row - t[0].row) -
           (t[1].row - t[0].row) * (t[2].col - t[0].col);
}

/* An edge of `a` has all of `b` on its outer side or on itself. */
static bool separates(const struct dx_strut_corner a[3], const struct dx_strut_corner b[3])
{
    for (int e = 0; e < 3; e++) {
        bool outside = true;

        for (int k = 0; k < 3; k++)
            outside &= area2((const struct dx_strut_corner[3]){a[e], a[(e + 1) % 3], b[k]}) <= 0;
        if (outside)
            return true;
    }
    return false;
}

/* What strut.h says a side goes through; how many. */
static int side_points(struct point p[2], uint8_t side, uint8_t len, int t)
{
    switch (side) {
    case DX_STRUT_CHAIN:
    case DX_STRUT_CHAIN + 1:
        p[0] = (struct point){0, t};
        p[1] = (struct point){1, t};
        return len;
    case DX_STRUT_LOWER:
    case DX_STRUT_LOWER + 1:
        p[0] = (struct point){0, t};
        p[1] = (struct point){2, t};
        return 2;
    case DX_STRUT_EVEN:
    case DX_STRUT_EVEN + 1:
        p[0] = (struct point){-1, t};
        p[1] = (struct point){len, t};
        return 2;
    case DX_STRUT_LONGER:
    case DX_STRUT_LONGER + 1:
        p[0] = (struct point){-1, t};
        p[1] = (struct point){2, t};
        return 2;
    default:
        p[0] = (struct point){-1, t};
        p[1] = (struct point){1, t};
        return 2;
    }
}

static bool has(const struct dx_strut *s, const struct dx_strut_corner t[3], struct point p)
{
    return same(corner(s, t[0]), p) || same(corner(s, t[1]), p) || same(corner(s, t[2]), p);
}

/* The triangles of one side, from `t` on: corners and cut as documented. Returns how many. */
static unsigned check_side(const struct dx_strut *s, struct dx_strut_corner (*t)[3], uint8_t side,
                           int sign)
{
    const struct point a = {-1, 0}, b = {s->len, 0};
    struct point p[2];
    int n = side == DX_STRUT_OPEN ? 0 : side_points(p, side, s->len, sign);

    if (n == 1)
        assert_true(has(s, t[0], a) && has(s, t[0], p[0]) && has(s, t[0], b));
    if (n < 2)
        return (unsigned)n;
    if (side % 2) { /* cut from A to side[1] */
        assert_true(has(s, t[0], a) && has(s, t[0], p[0]) && has(s, t[0], p[1]));
        assert_true(has(s, t[1], a) && has(s, t[1], p[1]) && has(s, t[1], b));
    } else { /* from B to side[0] */
        assert_true(has(s, t[0], a) && has(s, t[0], p[0]) && has(s, t[0], b));
        assert_true(has(s, t[1], p[0]) && has(s, t[1], p[1]) && has(s, t[1], b));
    }
    return 2;
}

static void test_every_code(void **state)
{
    int n_valid = 0;

    (void)state;
    for (int code = 0; code < 256; code++) {
        struct dx_strut_corner t[DX_STRUT_MAX_TRIANGLES][3];
        struct dx_strut s;
        unsigned n = dx_strut_triangles(t, (uint8_t)code), n_first;

        if (!dx_strut_decode(&s, (uint8_t)code)) {
            assert_int_equal(n, 0);
            continue;
        }
        n_valid++;
        assert_int_equal(dx_strut_code(&s), code);
        n_first = check_side(&s, t, s.first, -1);
        assert_int_equal(n, n_first + check_side(&s, t + n_first, s.second, 1));
        assert_true(n >= 1 && n <= DX_STRUT_MAX_TRIANGLES);
        for (unsigned i = 0; i < n; i++) {
            assert_true(area2(t[i]) > 0);
            for (unsigned j = 0; j < i; j++)
                assert_true(separates(t[i], t[j]) || separates(t[j], t[i]));
        }
    }
    /* sides that a length has: 2 x 5 less "nothing", and 5 x 9 less "nothing"; down and across */
    assert_int_equal(n_valid, 2 * (2 * 6 - 1 + 5 * 9 - 1));
}

/* No corner is a dexel that the strut spans. */
static void test_spans_only_missing(void **state)
{
    (void)state;
    for (int code = 1; code < DX_STRUT_CODES; code++) {
        struct dx_strut_corner t[DX_STRUT_MAX_TRIANGLES][3];
        struct dx_strut s;
        unsigned n = dx_strut_triangles(t, (uint8_t)code);

        if (!dx_strut_decode(&s, (uint8_t)code))
            continue;
        for (unsigned k = 0; k < 3 * n; k++) {
            struct point p = corner(&s, t[k / 3][k % 3]);

            assert_true(p.along >= -1 && p.along <= 2 && p.across >= -1 && p.across <= 1);
            assert_false(p.across == 0 && p.along >= 0 && p.along < s.len);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_code),
        cmocka_unit_test(test_spans_only_missing),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
