/* dexel info: the frames of scans and recordings, each decoded. */
#include "tools/info.h"

#include "tools/source.h"

#include <errno.h>
#include <string.h>

#define MAX_LISTED 64 /* as of an MCAP file */

struct tally {
    struct dx_geometry *g;
    struct dx_plane plane;
    uint64_t number; /* of the frame in `plane` */
    bool filling;
    uint8_t attr_bytes;
    uint64_t n_frames, n_geometries, n_dexels, n_valid;
    struct dx_err *err;
};

static int tally_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct tally *t = ctx;
    int rc;

    dx_plane_fini(&t->plane);
    t->filling = false;
    rc = dx_plane_init_for(&t->plane, g, attr_bytes);
    if (rc < 0)
        return dx_err_set(t->err, rc, "%ux%u: %s", g->width, g->height, strerror(-rc));
    dx_geometry_unref(t->g);
    t->g = dx_geometry_ref(g);
    t->attr_bytes = attr_bytes;
    t->n_geometries++;
    return 0;
}

static struct dx_plane *tally_plane(void *ctx, uint64_t number)
{
    struct tally *t = ctx;

    if (!t->g)
        return NULL;
    if (!t->filling || number != t->number) {
        dx_plane_clear(&t->plane);
        t->number = number;
        t->filling = true;
    }
    return &t->plane;
}

static void tally_deliver(void *ctx, const struct dx_frame_part *part)
{
    struct tally *t = ctx;
    size_t n = dx_plane_n_dexels(&t->plane);

    if (!part->last)
        return;
    t->filling = false;
    t->n_frames++;
    t->n_dexels += n;
    for (size_t k = 0; k < n; k++)
        t->n_valid += dx_plane_range(&t->plane, k) != 0;
}

/* Where nobody counts the damaged ones, frames of which the first are all damaged are left alone: a
 * small file can hold millions. */
static bool is_hopeless(const struct tally *t, const json_t *damage, const uint64_t *n_damaged)
{
    return !n_damaged && t->n_frames == 0 && json_array_size(damage) == MAX_LISTED;
}

/* Every frame; a damaged one is told and passed over. */
static int read_frames(const struct dx_driver *driver, struct dx_device *dev, struct tally *t,
                       json_t *damage, uint64_t *n_damaged)
{
    const struct dx_frame_sink sink = {t, tally_geometry, tally_plane, tally_deliver};
    struct dx_block block;
    int rc = 0;

    while (!is_hopeless(t, damage, n_damaged) && (rc = driver->read(dev, &block, t->err)) == 0) {
        rc = driver->decode(dev, &block, &sink, t->err);
        if (rc && rc != DX_DRIVER_E_CORRUPT)
            return rc;
        if (rc && n_damaged)
            ++*n_damaged;
        if (rc && json_array_size(damage) < MAX_LISTED)
            json_array_append_new(damage, dx_info_damage(0, block.len, t->err->text));
    }
    return rc < 0 ? rc : 0;
}

static void tell_geometry(json_t *out, const struct tally *t, const struct dx_fit_report *fit)
{
    json_object_set_new(out, "geometry", json_string(dx_model_name(t->g->model)));
    json_object_set_new(out, "width", json_integer(t->g->width));
    json_object_set_new(out, "height", json_integer(t->g->height));
    json_object_set_new(out, "seam_closed", json_boolean(t->g->wrap));
    json_object_set_new(out, "exact_points", json_boolean(t->g->exact));
    json_object_set_new(out, "unit_m", json_real((double)t->g->unit_m));
    json_object_set_new(out, "attribute_bytes", json_integer(t->attr_bytes));
    json_object_set_new(out, "geometries", json_integer((json_int_t)t->n_geometries));
    if (fit) {
        json_object_set_new(out, "rms_dexel", json_real(fit->rms_dexel));
        json_object_set_new(out, "largest_range_m", json_real(fit->max_range_m));
    }
    json_object_set_new(out, "valid",
                        json_real(t->n_dexels ? (double)t->n_valid / (double)t->n_dexels : 0));
}

int dx_info_frames(json_t *out, json_t *damage, uint64_t *n_damaged, const struct dx_driver *driver,
                   const char *path, struct dx_err *err)
{
    /* they are counted: the order says nothing, and the file's is read in one go */
    const struct dx_file_config config = {
        .path = path, .attr_bytes = -1, .fit.seam = -1, .any_order = true};
    struct tally t = {.err = err};
    struct dx_device *dev;
    int rc = driver->open(&dev, &config, err);

    if (rc)
        return rc < 0 ? rc : -EBADMSG;
    rc = driver->start(dev, err);
    if (rc == 0)
        rc = read_frames(driver, dev, &t, damage, n_damaged);
    json_object_set_new(out, "frames", json_integer((json_int_t)t.n_frames));
    if (t.g)
        tell_geometry(out, &t, dx_source_fit_report(driver, dev));
    driver->stop(dev);
    driver->close(dev);
    dx_plane_fini(&t.plane);
    dx_geometry_unref(t.g);
    return rc;
}

/* Of clouds of another program what cannot be decoded says nothing against the file. */
bool dx_info_decode(json_t *out, const struct dx_driver *driver, const char *path)
{
    json_t *damage;
    struct dx_err err = {""};
    int rc;

    if (!driver)
        return true;
    damage = json_array();
    rc = dx_info_frames(out, damage, NULL, driver, path, &err);
    if (rc < 0)
        json_object_set_new(out, "not_decoded",
                            json_string(err.text[0] ? err.text : strerror(-rc)));
    else if (json_array_size(damage))
        json_object_set(out, "not_decoded", json_object_get(json_array_get(damage, 0), "text"));
    json_decref(damage);
    return rc >= 0 || driver != &dx_recorded_driver;
}
