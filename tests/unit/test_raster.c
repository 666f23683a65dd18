/* The rasteriser: exact coverage, shared edges, depth, clipping to the image; a scene through the
 * camera. */
#include "core/base/hash.h"
#include "tools/raster.h"
#include "tools/render.h"

#include <errno.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

static const uint8_t white[3] = {255, 255, 255};

static struct dx_raster image(uint32_t width, uint32_t height)
{
    struct dx_raster r;

    assert_int_equal(dx_raster_init(&r, width, height, white), 0);
    return r;
}

static void triangle(struct dx_raster *r, const float xy[6], float depth, float grey)
{
    struct dx_raster_vertex v[3];

    for (int k = 0; k < 3; k++)
        v[k] = (struct dx_raster_vertex){xy[2 * k], xy[2 * k + 1], depth, {grey, grey, grey}};
    dx_raster_triangle(r, v);
}

/* One character a pixel: '.' background, else the first digit of grey / 10. */
static void assert_picture(const struct dx_raster *r, const char *expected)
{
    char found[65];

    for (uint32_t k = 0; k < r->width * r->height; k++)
        found[k] = r->rgb[3 * k] == 255 ? '.' : (char)('0' + r->rgb[3 * k] / 10);
    found[r->width * r->height] = 0;
    assert_string_equal(found, expected);
}

static void test_covers_pixel_centres(void **state)
{
    struct dx_raster r = image(6, 4);

    (void)state;
    triangle(&r, (float[]){1, 0, 5, 0, 1, 4}, 1, 10);
    /* Centres on the slanted edge x + y = 5 lie on a right-hand edge: not covered. */
    assert_picture(&r, ".111.."
                       ".11..."
                       ".1...."
                       "......");
    dx_raster_fini(&r);
}

static void test_either_orientation_is_the_same(void **state)
{
    struct dx_raster r = image(6, 4), s = image(6, 4);

    (void)state;
    triangle(&r, (float[]){0.3f, 0.2f, 5.7f, 1.1f, 2.2f, 3.9f}, 1, 10);
    triangle(&s, (float[]){2.2f, 3.9f, 5.7f, 1.1f, 0.3f, 0.2f}, 1, 10);
    assert_memory_equal(r.rgb, s.rgb, 6 * 4 * 3);
    dx_raster_fini(&r);
    dx_raster_fini(&s);
}

/* A fan around a point: each pixel once, whichever triangle owns the shared edges. */
static void test_shared_edges_have_one_owner(void **state)
{
    struct dx_raster r = image(8, 8);
    static const float rim[][2] = {{0, 0}, {4, 0}, {8, 0}, {8, 4}, {8, 8}, {4, 8}, {0, 8}, {0, 4}};
    unsigned n_covered[64] = {0};

    (void)state;
    for (int k = 0; k < 8; k++) {
        const float *a = rim[k], *b = rim[(k + 1) % 8];

        for (int p = 0; p < 64; p++)
            r.depth[p] = INFINITY;
        triangle(&r, (float[]){3.5f, 4.5f, a[0], a[1], b[0], b[1]}, 1, 10);
        for (int p = 0; p < 64; p++)
            n_covered[p] += isfinite(r.depth[p]) ? 1 : 0;
    }
    for (int p = 0; p < 64; p++)
        assert_int_equal(n_covered[p], 1);
    dx_raster_fini(&r);
}

static void test_nearer_wins_in_any_order(void **state)
{
    struct dx_raster r = image(4, 2);
    static const float all[] = {-9, -9, 30, -9, -9, 30}, left[] = {0, -2, 2, -2, 0, 60};

    (void)state;
    triangle(&r, left, 1, 10);
    triangle(&r, all, 2, 20);
    assert_picture(&r, "1122"
                       "1122");
    triangle(&r, left, 3, 30);
    assert_picture(&r, "1122"
                       "1122");
    triangle(&r, all, 0.5f, 40);
    assert_picture(&r, "4444"
                       "4444");
    dx_raster_fini(&r);
}

static void test_drops_what_is_not_a_number(void **state)
{
    struct dx_raster r = image(2, 2);

    (void)state;
    triangle(&r, (float[]){NAN, 0, 9, 0, 0, 9}, 1, 10);
    triangle(&r, (float[]){-9, -9, 1e30f, 0, 0, 9}, 1, 10);
    triangle(&r, (float[]){-9, -9, 9, 0, 0, 9}, INFINITY, 10);
    triangle(&r, (float[]){0, 0, 1, 1, 2, 2}, 1, 10);
    assert_picture(&r, "....");
    dx_raster_fini(&r);
    assert_int_equal(dx_raster_init(&r, 0, 2, white), -EINVAL);
    assert_int_equal(dx_raster_init(&r, 2, DX_RASTER_MAX_SIDE + 1, white), -EINVAL);
}

static void test_colour_is_linear_and_halving_averages(void **state)
{
    struct dx_raster r = image(4, 2);
    struct dx_raster_vertex v[3] = {
        {0, -1, 1, {0, 0, 0}}, {80, -1, 1, {200, 0, 0}}, {0, 79, 1, {0, 100, 0}}};
    uint8_t half[6];

    (void)state;
    dx_raster_triangle(&r, v); /* red = 2.5 x, green = 1.25 (y + 1) */
    assert_int_equal(r.rgb[0], 1);
    assert_int_equal(r.rgb[3 * 3], 9);
    assert_int_equal(r.rgb[3 * 4 + 1], 3);
    dx_raster_halve(half, &r);
    assert_int_equal(half[3], (r.rgb[6] + r.rgb[9] + r.rgb[18] + r.rgb[21] + 2) / 4);
    dx_raster_fini(&r);
}

/* ---- a mesh through a camera
 * ---------------------------------------------------------------------- */

static struct dx_mesh wall(void)
{
    struct dx_mesh m;
    static const float corners[] = {4, 3, -2, 4, -3, -2, 4, 3, 2, 4, -3, 2};

    assert_int_equal(dx_mesh_init(&m, 4, 2, 0, 0), 0);
    memcpy(m.xyz, corners, sizeof(corners));
    /* Counter-clockwise as seen from the origin. */
    memcpy(m.index, (uint32_t[]){0, 1, 3, 0, 3, 2}, 24);
    return m;
}

static size_t n_drawn(const struct dx_mesh *m, const struct dx_camera *c, uint32_t w, uint32_t h,
                      uint64_t *digest)
{
    static const float rgb[12] = {10, 0, 0, 20, 0, 0, 30, 0, 0, 40, 0, 0};
    struct dx_raster r = image(w, h);
    size_t n = 0;

    assert_int_equal(dx_render_mesh(&r, m, rgb, c), 0);
    for (size_t k = 0; k < (size_t)w * h; k++)
        n += isfinite(r.depth[k]) ? 1 : 0;
    *digest = dx_hash(0, r.rgb, (size_t)w * h * 3);
    dx_raster_fini(&r);
    return n;
}

static void test_scanner_sees_the_wall_whole(void **state)
{
    struct dx_mesh m = wall();
    struct dx_view_frame f;
    struct dx_camera c;
    uint64_t digest;
    uint32_t height = 0;
    size_t n;

    (void)state;
    assert_int_equal(dx_view_frame_of(&f, &m), 0);
    assert_true(f.up[2] == 1 && f.ahead[0] > 0.99);
    dx_camera_scanner(&c, &f, &m, 120, &height);
    assert_false(c.panorama);
    assert_in_range(height, 79, 81); /* 6 x 4 */
    n = n_drawn(&m, &c, 120, height, &digest);
    assert_in_range(n, 120 * 80 * 88 / 100, 120 * 80);
    c.cull = true; /* its face is towards us */
    assert_int_equal(n_drawn(&m, &c, 120, height, &digest), n);
    dx_mesh_fini(&m);
}

static void test_orbit_culls_the_back(void **state)
{
    struct dx_mesh m = wall();
    struct dx_view_frame f;
    struct dx_camera c;
    uint64_t digest;
    uint32_t height = 80;

    (void)state;
    assert_int_equal(dx_view_frame_of(&f, &m), 0);
    dx_camera_orbit(&c, &f, &m, 120, &height, 0, 0.5, 0);
    assert_true(n_drawn(&m, &c, 120, 80, &digest) > 4000);
    dx_camera_orbit(&c, &f, &m, 120, &height, 3.14159, 0.5, 0);
    assert_int_equal(n_drawn(&m, &c, 120, 80, &digest), 0);
    dx_mesh_fini(&m);
}

static void test_near_plane_cuts(void **state)
{
    struct dx_mesh m = wall();
    struct dx_camera c = {.right = {0, -1, 0},
                          .down = {0, 0, -1},
                          .forward = {1, 0, 0},
                          .scale = 40,
                          .cx = 60,
                          .cy = 40,
                          .near_m = 0.1};
    uint64_t digest;

    (void)state;
    m.xyz[1] = m.xyz[7] = 5;
    m.xyz[0] = m.xyz[6] = -4; /* the left end goes through the eye's plane to behind it */
    assert_in_range(n_drawn(&m, &c, 120, 80, &digest), 1500, 120 * 80);
    m.xyz[3] = m.xyz[9] = -4; /* all behind */
    assert_int_equal(n_drawn(&m, &c, 120, 80, &digest), 0);
    dx_mesh_fini(&m);
}

/* Azimuths around the whole turn: the triangle across the back is at both ends of the image. */
static void test_panorama_wraps(void **state)
{
    struct dx_camera c = {.panorama = true,
                          .right = {0, -1, 0},
                          .down = {0, 0, -1},
                          .forward = {1, 0, 0},
                          .scale = 20,
                          .cx = 62.832,
                          .cy = 30};
    struct dx_mesh m = wall();
    uint64_t digest, again;
    struct dx_raster r = image(126, 60);
    static const float rgb[12];

    (void)state;
    for (int k = 0; k < 4; k++)
        m.xyz[3 * k] = -4;
    assert_true(n_drawn(&m, &c, 126, 60, &digest) > 300);
    n_drawn(&m, &c, 126, 60, &again);
    assert_true(digest == again);
    assert_int_equal(dx_render_mesh(&r, &m, rgb, &c), 0);
    assert_true(isfinite(r.depth[30 * 126]) && isfinite(r.depth[30 * 126 + 125]));
    assert_true(isinf(r.depth[30 * 126 + 63]));
    dx_raster_fini(&r);
    dx_mesh_fini(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_covers_pixel_centres),
        cmocka_unit_test(test_either_orientation_is_the_same),
        cmocka_unit_test(test_shared_edges_have_one_owner),
        cmocka_unit_test(test_nearer_wins_in_any_order),
        cmocka_unit_test(test_drops_what_is_not_a_number),
        cmocka_unit_test(test_colour_is_linear_and_halving_averages),
        cmocka_unit_test(test_scanner_sees_the_wall_whole),
        cmocka_unit_test(test_orbit_culls_the_back),
        cmocka_unit_test(test_near_plane_cuts),
        cmocka_unit_test(test_panorama_wraps),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
