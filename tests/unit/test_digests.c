/*
 * Chunks of small scenes by digests that are written down: the same bytes by every compiler, on
 * every kind of processor, and from one version to the next. A change that means to change them
 * writes down the new ones and says why.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include "core/base/hash.h"
#include "core/grid/lod.h"
#include "core/grid/terrain.h"
#include "core/wire/chunk.h"
#include "tests/unit/scene_rig.h"

#include <stdio.h>
#include <stdlib.h>

enum way { AS_IT_IS, WITH_NORMALS, SMOOTHED, AVERAGED };

struct desk {
    struct dx_tile tile;
    struct dx_tile_mesh whole, cut;
    uint8_t body[DX_WIRE_MAX_BODY];
};

/* Three frames of a scene with noise and drop-outs. */
static struct dx_terrain *mesh_scene(struct rig *r, enum dx_scene scene, enum way way)
{
    struct dx_terrain_params params;
    struct dx_terrain *t;

    rig_init(r, scene, 100, 150);
    r->config.sigma[0] = 0.004;
    r->config.dropout = 0.01;
    r->config.seed = 5;
    rig_open(r);
    dx_terrain_params_default(&params);
    params.normals = way == WITH_NORMALS;
    params.smooth = way == SMOOTHED;
    params.ingest.filter = way == AVERAGED ? DX_FILTER_MEAN : DX_FILTER_OFF;
    assert_int_equal(dx_terrain_new(&t, r->g, &params, r->config.attr_bytes), 0);
    for (uint64_t n = 0; n < 3; n++) {
        rig_cast(r, n);
        dx_terrain_publish(t, &r->plane, 0, r->g->width, NULL);
        dx_terrain_commit(t, NULL);
    }
    return t;
}

static size_t put(struct desk *d, const struct dx_terrain *t, enum dx_encoding encoding)
{
    if (encoding == DX_ENCODING_Q16)
        return dx_chunk_put_q16(d->body, &d->tile);
    if (encoding == DX_ENCODING_DELTA)
        return dx_chunk_put_delta(d->body, &d->tile);
    return dx_chunk_put_f32(d->body, &d->tile, dx_terrain_tiling(t), dx_terrain_geometry(t));
}

static uint64_t digest(struct desk *d, const struct dx_terrain *t, enum dx_encoding encoding)
{
    uint64_t h = 1;

    for (uint32_t n = 0; n < dx_tiling_n_tiles(dx_terrain_tiling(t)); n++)
        if (dx_terrain_tile(t, n, &d->tile))
            h = dx_hash(h, d->body, put(d, t, encoding));
    return h;
}

static uint64_t digest_level(struct desk *d, const struct dx_terrain *t)
{
    const struct dx_lod_level levels[DX_LOD_SLOTS] = {{.bound = 32}};
    struct dx_lod_scratch *scratch = dx_lod_scratch_new();
    struct dx_lod *lod = NULL;
    uint64_t h = 1;

    assert_true(scratch && dx_lod_new(&lod, t, NULL) == 0);
    dx_lod_update(lod, levels, NULL);
    for (uint32_t n = 0; n < dx_tiling_n_tiles(dx_terrain_tiling(t)); n++) {
        if (!dx_terrain_tile(t, n, &d->tile))
            continue;
        dx_tile_mesh_build(&d->whole, &d->tile, dx_terrain_tiling(t), dx_terrain_geometry(t));
        dx_lod_mesh(&d->cut, lod, levels[0], &d->tile, &d->whole, scratch);
        h = dx_hash(h, d->body, dx_chunk_put_mesh(d->body, &d->cut));
    }
    dx_lod_free(lod);
    dx_lod_scratch_free(scratch);
    return h;
}

/* By scene and way: f32, q16, delta, a level of detail of two sigmas. */
static const struct {
    enum dx_scene scene;
    enum way way;
    uint64_t digest[DX_N_ENCODINGS + 1];
} written[] = {
    {DX_SCENE_HALL,
     AS_IT_IS,
     {0x0cfb51a92fb54ebf, 0xedc9ad1253887495, 0xc8a50659496aeefe, 0x807f19e2eb025e8d}},
    {DX_SCENE_HALL,
     WITH_NORMALS,
     {0x482edce4aa3fdbaa, 0xc106b51a1d69e12a, 0xd42ec68a2c08a84d, 0x194b85e129274a28}},
    {DX_SCENE_HALL,
     SMOOTHED,
     {0xc524c6785a6636cd, 0x9219d1bcb0fd0452, 0xc90f0816ee7b559c, 0x3539bb764cc3ddf7}},
    {DX_SCENE_HALL,
     AVERAGED,
     {0x41ada887d439a31b, 0xcbc3bceb0e49beb6, 0x939862ea2d4ca8d0, 0xd31ccf8d540c5417}},
    {DX_SCENE_OPEN,
     AS_IT_IS,
     {0xffa1aef6bbf0c841, 0x0614866e55050ed1, 0x1e53d1c4de50a2c2, 0xf01d2f4c2eaa87b1}},
    {DX_SCENE_FENCE,
     AS_IT_IS,
     {0x082082df2efc591a, 0x010de8c03719c5c9, 0x2bef7ce9f36e0ae7, 0xd54b7a7e234de2f6}},
    {DX_SCENE_MOVING_BOX,
     WITH_NORMALS,
     {0x9bd1648da56949b0, 0x0dbdde4cb221ec07, 0xb1f96e18368448cd, 0x4838d47aa1687633}},
};

static void chunks_are_those_written_down(void **state)
{
    struct desk *d = calloc(1, sizeof(*d));
    int n_wrong = 0;

    (void)state;
    assert_non_null(d);
    for (size_t k = 0; k < sizeof(written) / sizeof(*written); k++) {
        struct rig r;
        struct dx_terrain *t = mesh_scene(&r, written[k].scene, written[k].way);
        uint64_t got[DX_N_ENCODINGS + 1];

        for (unsigned e = 0; e < DX_N_ENCODINGS; e++)
            got[e] = digest(d, t, (enum dx_encoding)e);
        got[DX_N_ENCODINGS] = digest_level(d, t);
        for (unsigned e = 0; e <= DX_N_ENCODINGS; e++)
            if (got[e] != written[k].digest[e]) {
                n_wrong++;
                fprintf(stderr, "%zu, %u: 0x%016llx\n", k, e, (unsigned long long)got[e]);
            }
        dx_terrain_free(t);
        rig_close(&r);
    }
    free(d);
    assert_int_equal(n_wrong, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chunks_are_those_written_down),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
