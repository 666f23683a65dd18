/* A frame sink in memory, and the loop that feeds it. */
#include "tools/offline.h"

#include "core/grid/lod.h"
#include "core/wire/chunk.h"
#include "tools/now.h"
#include "tools/source.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* What the sink holds while frames come. */
struct sink {
    struct dx_terrain_params params; /* sigma: the estimate, once a frame has told it */
    struct dx_terrain *terrain;
    struct dx_plane plane; /* of the told geometry */
    uint64_t number;       /* of the frame in `plane` */
    bool filling;
    uint64_t n_frames; /* whole ones published */
};

static int on_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct sink *s = ctx;
    int rc;

    dx_terrain_free(s->terrain);
    s->terrain = NULL;
    dx_plane_fini(&s->plane);
    s->plane = (struct dx_plane){0};
    s->filling = false;
    rc = dx_terrain_new(&s->terrain, g, &s->params, attr_bytes);
    return rc < 0 ? rc : dx_plane_init_for(&s->plane, g, attr_bytes);
}

static struct dx_plane *on_plane(void *ctx, uint64_t number)
{
    struct sink *s = ctx;

    if (!s->terrain)
        return NULL;
    if (!s->filling || number != s->number) {
        dx_plane_clear(&s->plane);
        s->number = number;
        s->filling = true;
    }
    return &s->plane;
}

/* Every frame is published: the first one settles the noise, as in the service. */
static void on_deliver(void *ctx, const struct dx_frame_part *part)
{
    struct sink *s = ctx;

    if (!part->last)
        return;
    dx_terrain_publish(s->terrain, &s->plane, 0, s->plane.width, NULL);
    s->params = *dx_terrain_params(s->terrain);
    s->filling = false;
    s->n_frames++;
}

static void sink_fini(struct sink *s)
{
    dx_terrain_free(s->terrain);
    dx_plane_fini(&s->plane);
}

/* ---- frames
 * --------------------------------------------------------------------------------------- */

/* One block. 0; DX_DRIVER_E_EOF; negative. */
static int step(const struct dx_driver *driver, struct dx_device *dev,
                const struct dx_frame_sink *sink, struct dx_err *err)
{
    struct dx_block block;
    int rc = driver->read(dev, &block, err);

    if (rc == DX_DRIVER_E_AGAIN)
        return 0;
    if (rc == DX_DRIVER_E_GONE)
        return -EIO; /* err tells */
    if (rc != 0)
        return rc;
    rc = driver->decode(dev, &block, sink, err);
    if (rc == DX_DRIVER_E_CORRUPT)
        return -EBADMSG; /* err tells */
    return rc > 0 ? dx_err_set(err, -EPROTO, "%s: a frame before its geometry", block.source) : rc;
}

static int read_frames(struct sink *s, const struct dx_driver *driver, struct dx_device *dev,
                       const struct dx_offline_config *c, struct dx_err *err)
{
    const struct dx_frame_sink sink = {s, on_geometry, on_plane, on_deliver};
    int rc = driver->start(dev, err);

    while (rc == 0 && (c->frame == DX_OFFLINE_LAST || s->n_frames <= c->frame))
        rc = step(driver, dev, &sink, err);
    driver->stop(dev);
    if (rc < 0)
        return rc;
    if (!s->n_frames)
        return dx_err_set(err, -ENODATA, "%s: found no frame", c->path);
    if (c->frame != DX_OFFLINE_LAST && s->n_frames <= c->frame)
        return dx_err_set(err, -ENODATA, "%s: found %llu frames, expected one of number %llu",
                          c->path, (unsigned long long)s->n_frames, (unsigned long long)c->frame);
    return 0;
}

static struct dx_file_config source_of(const struct dx_offline_config *c)
{
    return (struct dx_file_config){.path = c->path,
                                   .topic = c->topic,
                                   .attr_bytes = -1,
                                   .fit = c->terrain.fit,
                                   .thin = c->thin,
                                   .exact = c->exact};
}

static int decode_file(struct sink *s, struct dx_offline *o, const struct dx_offline_config *c,
                       struct dx_err *err)
{
    const struct dx_driver *driver = dx_source_driver(c->path);
    const struct dx_file_config config = source_of(c);
    const struct dx_fit_report *report;
    struct dx_device *dev;
    int rc = driver->open(&dev, &config, err);

    if (rc < 0)
        return rc;
    rc = read_frames(s, driver, dev, c, err);
    report = dx_source_fit_report(driver, dev);
    if (report)
        o->fit = *report;
    driver->close(dev);
    return rc;
}

/* ---- tiles
 * ---------------------------------------------------------------------------------------- */

struct scratch {
    struct dx_tile tile;
    struct dx_tile_mesh mesh, whole;
    struct dx_lod *lod; /* NULL: the whole mesh */
    struct dx_lod_level level;
    struct dx_lod_scratch *cut;
    uint8_t *body; /* a chunk of any encoding */
};

/* The tile's mesh, by way of its chunk when an encoding is asked for. */
static int build_tile(struct scratch *x, const struct dx_terrain *t, int encoding)
{
    const struct dx_tiling *tiling = dx_terrain_tiling(t);
    const struct dx_geometry *g = dx_terrain_geometry(t);
    size_t len;

    switch (encoding) {
    case DX_ENCODING_Q16:
        len = dx_chunk_put_q16(x->body, &x->tile);
        break;
    case DX_ENCODING_DELTA:
        len = dx_chunk_put_delta(x->body, &x->tile);
        break;
    default:
        dx_tile_mesh_build(x->lod ? &x->whole : &x->mesh, &x->tile, tiling, g);
        if (x->lod)
            dx_lod_mesh(&x->mesh, x->lod, x->level, &x->tile, &x->whole, x->cut);
        if (encoding == DX_OFFLINE_PLAIN)
            return 0;
        len = x->lod ? dx_chunk_put_mesh(x->body, &x->mesh)
                     : dx_chunk_put_f32(x->body, &x->tile, tiling, g);
    }
    if (dx_terrain_params(t)->smooth)
        dx_chunk_set_smoothed(x->body);
    return dx_chunk_get(&x->mesh, x->body, len, tiling, g);
}

static void scratch_free(struct scratch *x)
{
    if (!x)
        return;
    dx_lod_scratch_free(x->cut);
    dx_lod_free(x->lod);
    free(x->body);
    free(x);
}

static struct scratch *scratch_new(const struct dx_terrain *t, const struct dx_offline_config *c,
                                   struct dx_pool *pool)
{
    const struct dx_lod_level levels[DX_LOD_SLOTS] = {c->lod};
    const int encoding = c->encoding < 0 ? DX_ENCODING_F32 : c->encoding;
    struct scratch *x = calloc(1, sizeof(*x));
    bool ok = x;

    if (!x)
        return NULL;
    x->level = c->lod;
    x->body = malloc(dx_chunk_max_len((enum dx_encoding)encoding));
    x->cut = dx_lod_scratch_new();
    if (!dx_lod_is_whole(c->lod))
        ok = dx_lod_new(&x->lod, t, pool) == 0;
    if (!ok || !x->body || !x->cut) {
        scratch_free(x);
        return NULL;
    }
    if (x->lod)
        dx_lod_update(x->lod, levels, pool);
    return x;
}

static int store_tiles(struct dx_offline *o, const struct dx_terrain *t,
                       const struct dx_offline_config *c, struct dx_pool *pool)
{
    struct scratch *x = scratch_new(t, c, pool);
    int rc = x ? 0 : -ENOMEM;

    for (uint32_t n = 0; rc == 0 && n < dx_tiling_n_tiles(dx_terrain_tiling(t)); n++) {
        if (!dx_terrain_tile(t, n, &x->tile))
            continue;
        rc = build_tile(x, t, c->encoding);
        if (rc == 0)
            rc = dx_mesh_store_set_mesh(o->mesh, &x->mesh);
    }
    dx_mesh_store_set_caps(o->mesh, dx_terrain_caps(t) & DX_CAP_FIRST,
                           dx_terrain_caps(t) & DX_CAP_LAST, o->geometry->flip);
    dx_mesh_store_commit(o->mesh);
    scratch_free(x);
    return rc;
}

static int check_encoding(const struct dx_plane *plane, const struct dx_offline_config *c,
                          struct dx_err *err)
{
    if (c->encoding == DX_ENCODING_Q16 && plane->range_bytes != 2)
        return dx_err_set(err, -EINVAL,
                          "%s: q16 needs ranges of 16 bits, found 32; a coarser unit helps",
                          c->path);
    return 0;
}

static int mesh_frame(struct dx_offline *o, const struct sink *s, const struct dx_offline_config *c,
                      struct dx_err *err)
{
    const struct dx_plane *plane = dx_terrain_published(s->terrain);
    struct dx_pool *pool;
    uint64_t start;
    int rc;

    o->geometry = dx_geometry_ref((struct dx_geometry *)dx_terrain_geometry(s->terrain));
    o->attr_bytes = plane->attr_bytes;
    o->frame = s->n_frames - 1;
    rc = check_encoding(plane, c, err);
    if (rc < 0)
        return rc;
    rc = dx_pool_new(&pool, c->n_threads);
    if (rc < 0)
        return dx_err_set(err, rc, "%u threads: %s", c->n_threads, strerror(-rc));
    start = dx_now_ns();
    dx_terrain_commit(s->terrain, pool);
    o->mesh_s = dx_seconds_since(start);
    o->params = *dx_terrain_params(s->terrain);
    rc = dx_mesh_store_new(&o->mesh, plane->height, plane->width, o->geometry->wrap, o->attr_bytes);
    if (rc == 0)
        rc = store_tiles(o, s->terrain, c, pool);
    dx_pool_free(pool);
    if (rc == 0 && c->lod_stats && !dx_lod_is_whole(c->lod))
        rc = dx_lod_stats_compute(&o->lod, s->terrain, c->lod);
    return rc < 0 ? dx_err_set(err, rc, "%s: the mesh: %s", c->path, strerror(-rc)) : 0;
}

int dx_offline_run(struct dx_offline *o, const struct dx_offline_config *config, struct dx_err *err)
{
    struct sink sink = {.params = config->terrain.params};
    int rc;

    *o = (struct dx_offline){0};
    *err = (struct dx_err){0};
    rc = decode_file(&sink, o, config, err);
    if (rc == 0)
        rc = mesh_frame(o, &sink, config, err);
    sink_fini(&sink);
    if (rc < 0) {
        dx_offline_fini(o);
        if (!err->text[0])
            dx_err_set(err, rc, "%s: %s", config->path, strerror(-rc));
    }
    return rc;
}

void dx_offline_fini(struct dx_offline *o)
{
    dx_mesh_store_free(o->mesh);
    dx_geometry_unref(o->geometry);
    *o = (struct dx_offline){0};
}

int dx_offline_check(const struct dx_offline_config *c, const char *command)
{
    const struct dx_file_config source = source_of(c);
    const char *encoding = c->encoding == DX_ENCODING_Q16     ? "q16"
                           : c->encoding == DX_ENCODING_DELTA ? "delta"
                                                              : NULL;

    if (dx_encoding_args_check(encoding, c->exact, !dx_lod_is_whole(c->lod), command) < 0)
        return -EINVAL;
    return dx_source_check(&source, command);
}
