/* A sink that takes the returns of whole frames out of their planes, by geometry and pose. */
#include "tools/cloud_read.h"

#include "drivers/file/cloud_bag.h"
#include "drivers/file/format.h"
#include "tools/source.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

struct sink {
    struct dx_point_list *list;
    uint64_t wanted, n_frames;
    struct dx_geometry *geometry;
    struct dx_plane plane;
    uint64_t number; /* of the frame in `plane` */
    bool filling;
    int failure; /* of deliver(), which returns nothing */
    struct dx_err *err;
};

bool dx_cloud_source_has_frames(const char *path)
{
    struct stat st;

    if (stat(path, &st) != 0)
        return strpbrk(path, "*?[");
    return S_ISDIR(st.st_mode) ||
           (S_ISREG(st.st_mode) && (dx_cloud_bag_probe(path) || dx_format_has_ext(path, ".mcap")));
}

static void point_of(double world[3], const struct dx_plane *plane, const struct dx_geometry *g,
                     uint32_t row, uint32_t col)
{
    const size_t k = (size_t)row * plane->width + col;
    const double *m = g->pose;
    float p[3];

    if (plane->xyz)
        memcpy(p, plane->xyz + 3 * k, sizeof(p));
    else
        dx_geometry_point(g, row, col, dx_plane_range(plane, k), p);
    for (int i = 0; i < 3; i++)
        world[i] = m[4 * i] * (double)p[0] + m[4 * i + 1] * (double)p[1] +
                   m[4 * i + 2] * (double)p[2] + m[4 * i + 3];
}

static int add_frame(struct sink *s)
{
    const struct dx_plane *plane = &s->plane;
    int rc = 0;

    if (s->wanted != DX_CLOUD_READ_ALL)
        s->list->n = 0;
    for (uint32_t row = 0; row < plane->height; row++)
        for (uint32_t col = 0; col < plane->width && rc == 0; col++) {
            double p[3];

            if (dx_plane_range(plane, (size_t)row * plane->width + col) == 0)
                continue;
            point_of(p, plane, s->geometry, row, col);
            rc = dx_point_list_add(s->list, p, s->err);
        }
    return rc;
}

static int on_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct sink *s = ctx;

    dx_geometry_unref(s->geometry);
    s->geometry = dx_geometry_ref(g);
    dx_plane_fini(&s->plane);
    s->plane = (struct dx_plane){0};
    s->filling = false;
    return dx_plane_init_for(&s->plane, g, attr_bytes);
}

static struct dx_plane *on_plane(void *ctx, uint64_t number)
{
    struct sink *s = ctx;

    if (!s->geometry || s->failure)
        return NULL;
    if (!s->filling || number != s->number) {
        dx_plane_clear(&s->plane);
        s->number = number;
        s->filling = true;
    }
    return &s->plane;
}

static void on_deliver(void *ctx, const struct dx_frame_part *part)
{
    struct sink *s = ctx;

    if (!part->last)
        return;
    if (s->wanted >= DX_CLOUD_READ_ALL || s->n_frames == s->wanted)
        s->failure = add_frame(s);
    s->n_frames++;
    s->filling = false;
}

/* One block. 0; DX_DRIVER_E_EOF; negative. */
static int step(const struct dx_driver *driver, struct dx_device *dev,
                const struct dx_frame_sink *sink, struct dx_err *err)
{
    const struct sink *s = sink->ctx;
    struct dx_block block;
    int rc = driver->read(dev, &block, err);

    if (rc == 0)
        rc = driver->decode(dev, &block, sink, err);
    if (s->failure < 0)
        return s->failure;
    if (rc == DX_DRIVER_E_CORRUPT || rc == DX_DRIVER_E_GONE)
        return -EBADMSG; /* err tells */
    return rc == DX_DRIVER_E_AGAIN ? 0 : rc;
}

static int read_frames(struct sink *s, const struct dx_driver *driver, struct dx_device *dev,
                       const char *path, struct dx_err *err)
{
    const struct dx_frame_sink sink = {s, on_geometry, on_plane, on_deliver};
    int rc = driver->start(dev, err);

    while (rc == 0 && (s->wanted >= DX_CLOUD_READ_ALL || s->n_frames <= s->wanted))
        rc = step(driver, dev, &sink, err);
    driver->stop(dev);
    if (rc < 0)
        return rc;
    if (s->n_frames == 0)
        return dx_err_set(err, -ENODATA, "%s: found no frame", path);
    if (s->wanted < DX_CLOUD_READ_ALL && s->n_frames <= s->wanted)
        return dx_err_set(err, -ENODATA, "%s: found %llu frames, expected one of number %llu", path,
                          (unsigned long long)s->n_frames, (unsigned long long)s->wanted);
    return 0;
}

static int read_source(struct dx_point_list *list, const struct dx_cloud_source *source,
                       struct dx_err *err)
{
    const struct dx_driver *driver = dx_source_driver(source->path);
    const struct dx_file_config config = {.path = source->path,
                                          .topic = source->topic,
                                          .fit.seam = -1,
                                          .exact = driver != &dx_recorded_driver};
    struct sink s = {.list = list, .wanted = source->frame, .err = err};
    struct dx_device *dev;
    int rc = driver->open(&dev, &config, err);

    if (rc)
        return rc < 0 ? rc : -ENODEV;
    rc = read_frames(&s, driver, dev, source->path, err);
    driver->close(dev);
    dx_geometry_unref(s.geometry);
    dx_plane_fini(&s.plane);
    return rc;
}

static bool is_empty(const char *path)
{
    struct stat st;

    return stat(path, &st) == 0 && st.st_size == 0;
}

int dx_cloud_read(struct dx_point_list *list, const struct dx_cloud_source *source,
                  struct dx_err *err)
{
    int rc;

    if (!dx_cloud_source_has_frames(source->path)) {
        rc = dx_point_list_read(list, source->path, err);
        return rc == 0 && list->n == 0 && !is_empty(source->path)
                   ? dx_err_set(err, -ENODATA, "%s: found no point", source->path)
                   : rc;
    }
    list->n = 0;
    *err = (struct dx_err){0};
    rc = read_source(list, source, err);
    if (rc < 0) {
        list->n = 0;
        if (!err->text[0])
            dx_err_set(err, rc, "%s: %s", source->path, strerror(-rc));
    }
    return rc;
}
