/*
 * What programs that were built against libdexel.so.0 rely on (on machines of 64 bits). Structures
 * that a program hands over, dexel_options and dexel_callbacks, may not change at all; those that
 * libdexel hands over may grow at their end. What must change otherwise gets another SONAME.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "client/dexel.h"

#define FIELD(type, member, at)                                                                    \
    {                                                                                              \
        "struct " #type ", " #member, offsetof(struct type, member), at                            \
    }

static const struct {
    const char *name;
    size_t now, then;
} fields[] = {
    FIELD(dexel_stream, name, 0),
    FIELD(dexel_stream, model, 8),
    FIELD(dexel_stream, height, 12),
    FIELD(dexel_stream, width, 16),
    FIELD(dexel_stream, tile_rows, 20),
    FIELD(dexel_stream, tile_cols, 24),
    FIELD(dexel_stream, wrap, 28),
    FIELD(dexel_stream, flip, 32),
    FIELD(dexel_stream, attr_bytes, 36),
    FIELD(dexel_stream, normals, 40),
    FIELD(dexel_stream, smoothed, 44),
    FIELD(dexel_stream, unit_m, 48),
    FIELD(dexel_stream, pose, 56),
    FIELD(dexel_stream, sigma, 152),
    FIELD(dexel_stream, tilt_deg, 176),
    FIELD(dexel_stream, noise_k, 184),
    FIELD(dexel_stream, cap_m, 192),
    FIELD(dexel_stream, lod_sigma, 200),
    FIELD(dexel_stream, stride, 208),
    FIELD(dexel_tile, row, 0),
    FIELD(dexel_tile, col, 4),
    FIELD(dexel_tile, n_vertices, 8),
    FIELD(dexel_tile, n_triangles, 12),
    FIELD(dexel_tile, xyz, 16),
    FIELD(dexel_tile, index, 24),
    FIELD(dexel_tile, dexel, 32),
    FIELD(dexel_tile, attr, 40),
    FIELD(dexel_tile, normal, 48),
    FIELD(dexel_commit, epoch, 0),
    FIELD(dexel_commit, frame, 8),
    FIELD(dexel_commit, host_ns, 16),
    FIELD(dexel_commit, device_ns, 24),
    FIELD(dexel_commit, clock_id, 32),
    FIELD(dexel_commit, n_dropped, 40),
    FIELD(dexel_commit, n_tiles, 48),
    FIELD(dexel_commit, partial, 52),
    FIELD(dexel_commit, snapshot, 56),
    FIELD(dexel_commit, cap_first, 60),
    FIELD(dexel_commit, cap_last, 64),
    FIELD(dexel_callbacks, stream, 0),
    FIELD(dexel_callbacks, reset, 8),
    FIELD(dexel_callbacks, tile, 16),
    FIELD(dexel_callbacks, raw_tile, 24),
    FIELD(dexel_callbacks, commit, 32),
    FIELD(dexel_callbacks, state, 40),
    FIELD(dexel_options, socket, 0),
    FIELD(dexel_options, stream, 8),
    FIELD(dexel_options, encoding, 16),
    FIELD(dexel_options, mode, 20),
    FIELD(dexel_options, want_attr, 24),
    FIELD(dexel_options, want_normals, 28),
    FIELD(dexel_options, min_interval_ms, 32),
    FIELD(dexel_options, tile_row0, 36),
    FIELD(dexel_options, tile_col0, 38),
    FIELD(dexel_options, n_tile_rows, 40),
    FIELD(dexel_options, n_tile_cols, 42),
    FIELD(dexel_options, lod_sigma, 48),
    FIELD(dexel_options, stride, 56),
    FIELD(dexel_options, reconnect, 60),
};

static void fields_are_where_they_were(void **state)
{
    (void)state;
    if (sizeof(void *) != 8)
        skip();
    for (size_t k = 0; k < sizeof(fields) / sizeof(fields[0]); k++)
        if (fields[k].now != fields[k].then)
            fail_msg("%s: at %zu, was at %zu", fields[k].name, fields[k].now, fields[k].then);
}

static void what_is_handed_over_has_its_size(void **state)
{
    (void)state;
    if (sizeof(void *) != 8)
        skip();
    assert_true(sizeof(struct dexel_stream) >= 216);
    assert_true(sizeof(struct dexel_tile) >= 56);
    assert_true(sizeof(struct dexel_commit) >= 72);
    assert_int_equal(sizeof(struct dexel_callbacks), 48);
    assert_int_equal(sizeof(struct dexel_options), 64);
}

static void values_are_what_they_were(void **state)
{
    (void)state;
    assert_true(DEXEL_F32 == 0 && DEXEL_Q16 == 1 && DEXEL_DELTA == 2);
    assert_true(DEXEL_LIVE == 0 && DEXEL_PULL == 1 && DEXEL_LOSSLESS == 2);
    assert_true(DEXEL_SPINNING == 1 && DEXEL_PINHOLE == 2 && DEXEL_TABLE == 3);
    assert_true(DEXEL_OPENING == 0 && DEXEL_LIVE_STATE == 1 && DEXEL_STALLED == 2 &&
                DEXEL_GONE == 3 && DEXEL_ENDED == 4 && DEXEL_FAULTED == 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_are_where_they_were),
        cmocka_unit_test(what_is_handed_over_has_its_size),
        cmocka_unit_test(values_are_what_they_were),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
