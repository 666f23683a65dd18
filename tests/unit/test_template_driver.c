/* The template for new drivers, on a pseudo-terminal: frames in any pieces, damage, the unplugging.
 */
#include "file_fixture.h"

#include "template_driver.c"

#define COLS 6
#define ROWS 4
#define LEN  (FRAME_HEAD + 2 * COLS * ROWS)

struct camera {
    int line; /* the camera's end of it */
    char node[64];
    struct dx_device *dev, *decoder;
    struct kept kept;
};

static void plug(struct camera *c)
{
    struct dx_template_config config = {.node = c->node};
    struct dx_err err = {""};
    char go[2];

    *c = (struct camera){.line = posix_openpt(O_RDWR | O_NOCTTY)};
    assert_true(c->line >= 0);
    assert_int_equal(grantpt(c->line), 0);
    assert_int_equal(unlockpt(c->line), 0);
    assert_int_equal(ptsname_r(c->line, c->node, sizeof(c->node)), 0);
    if (dx_template_driver.open(&c->dev, &config, &err) != 0)
        fail_msg("%s", err.text);
    assert_int_equal(dx_template_driver.open_decoder(&c->decoder, &config, &err), 0);
    assert_int_equal(dx_template_driver.start(c->dev, &err), 0);
    assert_int_equal(read(c->line, go, 2), 2);
    assert_memory_equal(go, "GO", 2);
}

static void unplug(struct camera *c)
{
    if (c->line >= 0)
        close(c->line);
    dx_template_driver.stop(c->dev);
    dx_template_driver.close(c->dev);
    dx_template_driver.close(c->decoder);
    dx_template_driver.close(NULL);
    kept_fini(&c->kept);
}

static void make_frame(uint8_t f[LEN], uint32_t number)
{
    memcpy(f, "DF", 2);
    dx_put_u16(f + 2, COLS);
    dx_put_u16(f + 4, ROWS);
    dx_put_u32(f + 6, number);
    for (size_t k = 0; k < COLS * ROWS; k++)
        dx_put_u16(f + FRAME_HEAD + 2 * k, (uint16_t)(1000 * number + k));
}

static void send_bytes(struct camera *c, const uint8_t *bytes, size_t len)
{
    assert_int_equal(write(c->line, bytes, len), len);
}

static int decode(struct camera *c, const uint8_t *bytes, size_t len, struct dx_err *err)
{
    struct dx_block b = {.bytes = exact_copy(bytes, len), .len = len, .source = "t"};
    struct dx_frame_sink sink = sink_to(&c->kept);
    int r = dx_template_driver.decode(c->decoder, &b, &sink, err);

    free((void *)b.bytes);
    return r;
}

/* Up to the next block. */
static struct dx_block await_block(struct camera *c)
{
    struct dx_err err = {""};
    struct dx_block b;
    int r;

    while ((r = dx_template_driver.read(c->dev, &b, &err)) == DX_DRIVER_E_AGAIN)
        ;
    if (r != 0)
        fail_msg("%d: %s", r, err.text);
    return b;
}

static void expect_frame(struct camera *c, uint32_t number, uint64_t as)
{
    struct dx_block b = await_block(c);
    struct dx_err err = {""};

    if (decode(c, b.bytes, b.len, &err) != 0)
        fail_msg("%s", err.text);
    assert_int_equal(c->kept.part.frame, as);
    for (size_t k = 0; k < COLS * ROWS; k++)
        assert_int_equal(dx_plane_range(&c->kept.plane, k), (uint16_t)(1000 * number + k));
}

static void takes_frames_cut_at_every_byte(void **state)
{
    struct dx_device_health h = {0};
    struct camera c;
    uint8_t f[LEN];

    (void)state;
    plug(&c);
    for (uint32_t cut = 1; cut < LEN; cut++) {
        struct dx_block b;

        make_frame(f, cut);
        send_bytes(&c, f, cut);
        assert_int_equal(dx_template_driver.read(c.dev, &b, NULL), DX_DRIVER_E_AGAIN);
        send_bytes(&c, f + cut, LEN - cut);
        expect_frame(&c, cut, cut - 1);
    }
    assert_int_equal(c.kept.n_geometries, 1);
    dx_template_driver.health(c.dev, &h);
    assert_int_equal(h.n_lost, 0);
    assert_int_equal(h.n_damaged, 0);
    unplug(&c);
}

static void finds_the_next_frame_after_damage_and_counts(void **state)
{
    struct dx_device_health h = {0};
    struct camera c;
    uint8_t f[LEN];

    (void)state;
    plug(&c);
    send_bytes(&c, (const uint8_t *)"rubbish DD", 10);
    make_frame(f, 7);
    send_bytes(&c, f, LEN);
    expect_frame(&c, 7, 0);
    make_frame(f, 10);
    send_bytes(&c, f, LEN);
    expect_frame(&c, 10, 1);
    dx_template_driver.health(c.dev, &h);
    assert_int_equal(h.n_lost, 2);
    assert_true(h.n_damaged > 0);
    unplug(&c);
}

static void refuses_every_cut_and_changed_block(void **state)
{
    struct camera c;
    struct dx_block b;
    struct dx_err err;
    uint8_t f[LEN], bytes[BLOCK_HEAD + LEN];

    (void)state;
    plug(&c);
    make_frame(f, 1);
    send_bytes(&c, f, LEN);
    b = await_block(&c);
    memcpy(bytes, b.bytes, b.len);
    for (size_t len = 0; len < b.len; len++)
        assert_int_equal(decode(&c, bytes, len, &err), DX_DRIVER_E_CORRUPT);
    for (size_t k = 0; k < BLOCK_HEAD + 6; k++) {
        memcpy(bytes, b.bytes, b.len);
        bytes[k] ^= 0x80;
        if (k != 6 && k != 7 && k != 8 && k != 9 && k != 10) /* spare; another unit */
            assert_int_equal(decode(&c, bytes, b.len, &err), DX_DRIVER_E_CORRUPT);
    }
    assert_non_null(strstr(err.text, "t: block 0: byte 12: "));
    unplug(&c);
}

static void an_unplugged_camera_is_gone(void **state)
{
    struct dx_template_config config = {.node = "/dev/no_such_node"};
    struct dx_device *dev;
    struct dx_err err;
    struct dx_block b;
    struct camera c;
    int r;

    (void)state;
    assert_int_equal(dx_template_driver.open(&dev, &config, &err), DX_DRIVER_E_GONE);
    assert_string_equal(err.text, "template: no camera at /dev/no_such_node");
    plug(&c);
    dx_template_driver.wake(c.dev);
    assert_int_equal(dx_template_driver.read(c.dev, &b, &err), DX_DRIVER_E_AGAIN);
    close(c.line);
    c.line = -1;
    while ((r = dx_template_driver.read(c.dev, &b, &err)) == DX_DRIVER_E_AGAIN)
        ;
    assert_int_equal(r, DX_DRIVER_E_GONE);
    unplug(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(takes_frames_cut_at_every_byte),
        cmocka_unit_test(finds_the_next_frame_after_damage_and_counts),
        cmocka_unit_test(refuses_every_cut_and_changed_block),
        cmocka_unit_test(an_unplugged_camera_is_gone),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
