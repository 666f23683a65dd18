/* Recordings of a simulated stream, played: frames, numbers, jumps, damage. */
#include "played_fixture.h"

#include "daemon/player.h"
#include "drivers/file/playlist.h"

#include <errno.h>

/* ---- playing ---------------------------------------------------------------------------------
 */

static struct dx_device *open_with(const struct dx_file_config *c)
{
    struct dx_device *dev = NULL;
    struct dx_err err = {""};

    if (dx_player_driver.open(&dev, c, &err) != 0)
        fail_msg("%s", err.text);
    assert_int_equal(dx_player_driver.start(dev, &err), 0);
    return dev;
}

static struct dx_device *open_player(const char *path, bool loop, double rate)
{
    return open_with(&(struct dx_file_config){.path = path, .loop = loop, .rate = rate});
}

static int play_block(struct dx_device *dev, struct kept *k)
{
    struct dx_frame_sink sink = sink_to(k);
    struct dx_err err = {""};
    struct dx_block block;
    int rc = dx_player_driver.read(dev, &block, &err);

    if (rc == 0 && dx_player_driver.decode(dev, &block, &sink, &err) != 0)
        fail_msg("%s", err.text);
    return rc;
}

/* Up to the end of a frame; a wake that was left over is no news. */
static int play(struct dx_device *dev, struct kept *k)
{
    int rc;

    do
        rc = play_block(dev, k);
    while (rc == DX_DRIVER_E_AGAIN || (rc == 0 && !k->part.last));
    return rc;
}

/* The plane is that of frame `number` of the scene. */
static void expect_frame(const struct kept *k, uint64_t number)
{
    struct dx_config config;
    struct dx_plane plane;
    struct dx_err err;

    assert_int_equal(dx_config_parse(&config, "t", YAML(5), strlen(YAML(5)), &err), 0);
    assert_int_equal(dx_plane_init_for(&plane, k->geometry, k->attr_bytes), 0);
    dx_scene_cast(&plane, k->geometry, &config.streams[0].source.synthetic.scene, number, 0,
                  k->geometry->width);
    for (size_t n = 0; n < dx_plane_n_dexels(&plane); n++)
        if (dx_plane_range(&plane, n) != dx_plane_range(&k->plane, n))
            fail_msg("frame %u differs in dexel %zu", (unsigned)number, n);
    dx_plane_fini(&plane);
    dx_config_fini(&config);
}

static void tells_where_a_stay_begins(void **state)
{
    char *folder = make_folder(), *path = path_in(folder, "r.mcap");
    struct dx_device *dev;
    struct dx_block block;
    struct dx_err err;
    uint64_t n = 0;
    int rc;

    (void)state;
    record(folder, "r.mcap", YAML(5), 0);
    dev = open_player(path, false, 0);
    while ((rc = dx_player_driver.read(dev, &block, &err)) != DX_DRIVER_E_EOF) {
        if (rc == DX_DRIVER_E_AGAIN)
            continue;
        assert_int_equal(block.first, n == 0 || n == RETURN * PARTS);
        n++;
    }
    assert_int_equal(n, FRAMES * PARTS);
    dx_player_driver.close(dev);
    free(path);
    remove_folder(folder);
}

static void plays_what_was_recorded(void **state)
{
    char *folder = make_folder(), *path = path_in(folder, "r*.mcap");
    struct dx_device *dev;
    struct kept k = {0};
    char text[256];

    (void)state;
    record(folder, "r.mcap", YAML(5), 1500000000u);
    assert_true(dx_playlist_wants(path));
    dev = open_player(path, false, 0);
    for (uint64_t n = 0; n < FRAMES; n++) {
        assert_int_equal(play(dev, &k), 0);
        assert_int_equal(k.part.frame, n);
        assert_int_equal(k.part.stamp.clock_id, DX_CLOCK_DEVICE);
        expect_frame(&k, n);
    }
    assert_int_equal(play(dev, &k), DX_DRIVER_E_EOF);
    assert_int_equal(k.n_geometries, 1);
    dx_player_driver.describe(dev, text, sizeof(text));
    assert_non_null(strstr(text, "recording of 'box', 4 files; moving-box: pinhole"));
    dx_player_driver.close(dev);
    kept_fini(&k);
    free(path);
    remove_folder(folder);
}

/* Numbers go on over the end and after a seek. */
static void jumps(void **state)
{
    char *folder = make_folder(), *path = path_in(folder, "r*.mcap");
    struct dx_player_status s;
    struct dx_device *dev;
    struct kept k = {0};

    (void)state;
    record(folder, "r.mcap", YAML(5), 1500000000u);
    dev = open_player(path, true, 0);
    for (uint64_t n = 0; n < 2 * FRAMES + 3; n++) {
        assert_int_equal(play(dev, &k), 0);
        assert_int_equal(k.part.frame, n);
    }
    expect_frame(&k, 2);
    assert_int_equal(play_block(dev, &k), 0); /* in the middle of frame 3 */
    dx_player_seek(dev, 1.9);                 /* frame 8 begins at 2.0 */
    assert_int_equal(play(dev, &k), 0);
    assert_int_equal(k.part.frame, 2 * FRAMES + 4);
    expect_frame(&k, 8);
    dx_player_status(dev, &s);
    assert_true(s.position_s > 2.1 && s.position_s < 2.25);
    assert_true(s.length_s > 4.9 && s.length_s < 5);
    dx_player_seek(dev, 0); /* the first of the first file */
    assert_int_equal(play(dev, &k), 0);
    expect_frame(&k, 0);
    dx_player_seek(dev, 4.75); /* of the last file */
    assert_int_equal(play(dev, &k), 0);
    expect_frame(&k, 19);
    dx_player_seek(dev, 1e6); /* behind the end: over it, it loops */
    assert_int_equal(play(dev, &k), 0);
    expect_frame(&k, 0);
    dx_player_driver.close(dev);
    kept_fini(&k);
    free(path);
    remove_folder(folder);
}

/* From 1.5 s to 2.9 s of the recording: frames 6 to 11, over and over. */
static void plays_a_stretch(void **state)
{
    char *folder = make_folder(), *path = path_in(folder, "r*.mcap");
    struct dx_file_config c = {.path = path, .start_s = 1.5, .end_s = 2.99};
    struct dx_device *dev;
    struct kept k = {0};
    struct dx_err err;

    (void)state;
    record(folder, "r.mcap", YAML(5), 1500000000u);
    dev = open_with(&c);
    for (uint64_t n = 6; n < 12; n++) {
        assert_int_equal(play(dev, &k), 0);
        assert_int_equal(k.part.frame, n);
        expect_frame(&k, n);
    }
    assert_int_equal(play(dev, &k), DX_DRIVER_E_EOF);
    dx_player_driver.close(dev);

    c.loop = true;
    dev = open_with(&c);
    for (uint64_t n = 0; n < 20; n++) {
        assert_int_equal(play(dev, &k), 0);
        assert_int_equal(k.part.frame, 6 + n);
        expect_frame(&k, 6 + n % 6);
    }
    dx_player_driver.close(dev);

    c.start_s = 100;
    assert_int_equal(dx_player_driver.open(&dev, &c, &err), -EINVAL);
    assert_non_null(strstr(err.text, "start is 100 s, and the recording has 4.9"));
    kept_fini(&k);
    free(path);
    remove_folder(folder);
}

static void stamps_anew_when_asked(void **state)
{
    char *folder = make_folder(), *path = path_in(folder, "r.mcap");
    struct dx_device *dev;
    struct kept k = {0};

    (void)state;
    record(folder, "r.mcap", YAML(5), 0);
    dev = open_player(path, false, 0);
    assert_int_equal(play(dev, &k), 0);
    assert_int_equal(play(dev, &k), 0);
    assert_int_equal(k.part.stamp.clock_id, DX_CLOCK_DEVICE);
    assert_int_equal(k.part.stamp.device_ns, 175000000); /* the last part of the second frame */
    dx_player_driver.close(dev);

    dev = open_with(&(struct dx_file_config){.path = path, .restamp = true});
    assert_int_equal(play(dev, &k), 0);
    assert_int_equal(k.part.stamp.clock_id, DX_CLOCK_MONOTONIC);
    assert_int_equal(k.part.stamp.device_ns, k.part.stamp.host_ns);
    dx_player_driver.close(dev);
    kept_fini(&k);
    free(path);
    remove_folder(folder);
}

static void pauses_and_steps(void **state)
{
    char *folder = make_folder(), *path = path_in(folder, "r.mcap");
    struct dx_player_status s;
    struct dx_device *dev;
    struct kept k = {0};

    (void)state;
    record(folder, "r.mcap", YAML(5), 0);
    dev = open_player(path, false, 0);
    dx_player_pause(dev, true);
    assert_int_equal(play_block(dev, &k), DX_DRIVER_E_AGAIN); /* the wake of the pause */
    dx_player_step(dev, 2);
    for (unsigned n = 0; n < 2 * PARTS; n++) {
        int rc = play_block(dev, &k);

        while (rc == DX_DRIVER_E_AGAIN)
            rc = play_block(dev, &k);
        assert_int_equal(rc, 0);
    }
    dx_player_driver.wake(dev);
    assert_int_equal(play_block(dev, &k), DX_DRIVER_E_AGAIN); /* paused again */
    dx_player_status(dev, &s);
    assert_true(s.paused && s.n_frames == 2 && s.rate == 0);
    dx_player_pause(dev, false);
    dx_player_rate(dev, 1000);
    while (play(dev, &k) != DX_DRIVER_E_EOF)
        ;
    expect_frame(&k, FRAMES - 1);
    dx_player_status(dev, &s);
    assert_true(!s.paused && s.n_frames == FRAMES && s.rate == 1000);
    dx_player_driver.close(dev);
    kept_fini(&k);
    free(path);
    remove_folder(folder);
}

static struct buffer read_file(const char *folder, const char *name)
{
    char *path = path_in(folder, name);
    FILE *f = fopen(path, "rb");
    struct buffer b = {0};
    uint8_t room[4096];
    size_t n;

    assert_non_null(f);
    while ((n = fread(room, 1, sizeof(room), f)) > 0)
        buffer_add(&b, room, n);
    fclose(f);
    free(path);
    return b;
}

/* Cut anywhere: the frames of whole chunks come, and they are right. */
static void plays_what_is_left(void **state)
{
    char *folder = make_folder(), *path = path_in(folder, "cut.mcap");
    struct buffer whole;
    unsigned before = 0;

    (void)state;
    record(folder, "r.mcap", YAML(5), 0);
    whole = read_file(folder, "r.mcap");
    for (size_t len = whole.len / 3; len < whole.len; len += 37) {
        struct dx_device *dev;
        struct kept k = {0};
        unsigned n = 0;

        write_file(folder, "cut.mcap", whole.bytes, len);
        dev = open_player(path, false, 0);
        while (play(dev, &k) == 0)
            n++;
        assert_true(n >= before && n <= FRAMES);
        if (n)
            expect_frame(&k, n - 1);
        before = n;
        dx_player_driver.close(dev);
        kept_fini(&k);
    }
    assert_int_equal(before, FRAMES);
    buffer_fini(&whole);
    free(path);
    remove_folder(folder);
}

static void expect_refusal(const char *path, const char *text)
{
    const struct dx_file_config c = {.path = path};
    struct dx_device *dev = NULL;
    struct dx_err err = {""};

    assert_true(dx_player_driver.open(&dev, &c, &err) < 0);
    if (!strstr(err.text, text))
        fail_msg("found '%s', expected '%s'", err.text, text);
}

/* A file that was cut anywhere before its first chunk: those beside it are played whole. */
static void passes_over_what_a_kill_has_left(void **state)
{
    char *folder = make_folder(), *all = path_in(folder, "*.mcap");
    struct buffer whole;
    size_t len;

    (void)state;
    record(folder, "b.mcap", YAML(5), 0);
    record(folder, "c.mcap", YAML(5), 0);
    whole = read_file(folder, "b.mcap");
    for (len = 0; len < whole.len / 8; len += 1 + len / 16) {
        struct dx_device *dev;
        struct kept k = {0};
        unsigned n = 0;

        write_file(folder, "a.mcap", whole.bytes, len);
        assert_true(dx_playlist_wants(all));
        dev = open_player(all, false, 0);
        while (play(dev, &k) == 0)
            n++;
        assert_true(n >= 2 * FRAMES && n < 3 * FRAMES);
        dx_player_driver.close(dev);
        kept_fini(&k);
    }
    assert_true(len > 300); /* the configuration was cut, too */
    buffer_fini(&whole);
    free(all);
    remove_folder(folder);
}

/* Rotation and people name files as they like: the times in them tell their order. */
static void plays_in_the_order_of_time(void **state)
{
    char *folder = make_folder(), *all = path_in(folder, "*.mcap");
    char *third = path_in(folder, "r_0003.mcap");
    char *moved = path_in(folder, "a.mcap");
    struct dx_player_status s;
    struct dx_device *dev;
    struct kept k = {0};

    (void)state;
    record(folder, "r.mcap", YAML(5), 1500000000u);
    assert_int_equal(rename(third, moved), 0); /* now the first by name */
    dev = open_player(all, false, 0);
    dx_player_status(dev, &s);
    assert_true(s.length_s > 4.9 && s.length_s < 5);
    for (uint64_t n = 0; n < FRAMES; n++) {
        assert_int_equal(play(dev, &k), 0);
        assert_int_equal(k.part.frame, n);
        expect_frame(&k, n);
    }
    dx_player_driver.close(dev);
    kept_fini(&k);
    free(all);
    free(third);
    free(moved);
    remove_folder(folder);
}

static void refuses_what_is_no_recording(void **state)
{
    char *folder = make_folder(), *all = path_in(folder, "*.mcap"), *b = path_in(folder, "b.mcap");
    struct buffer whole;

    (void)state;
    record(folder, "a.mcap", YAML(5), 0);
    record(folder, "b.mcap", YAML(6), 0);
    expect_refusal(all, "recorded with another configuration than");
    whole = read_file(folder, "b.mcap");
    write_file(folder, "b.mcap", whole.bytes, 60);
    expect_refusal(b, "ends before its configuration");
    write_file(folder, "b.mcap", "text", 4);
    assert_false(dx_playlist_wants(b));
    buffer_fini(&whole);
    free(all);
    free(b);
    remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plays_what_was_recorded),
        cmocka_unit_test(tells_where_a_stay_begins),
        cmocka_unit_test(jumps),
        cmocka_unit_test(plays_a_stretch),
        cmocka_unit_test(stamps_anew_when_asked),
        cmocka_unit_test(pauses_and_steps),
        cmocka_unit_test(plays_what_is_left),
        cmocka_unit_test(passes_over_what_a_kill_has_left),
        cmocka_unit_test(plays_in_the_order_of_time),
        cmocka_unit_test(refuses_what_is_no_recording),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
