/* Scans and recordings; the latter as a driver over the list of their blocks. */
#include "tools/source.h"

#include "daemon/config.h"
#include "drivers/file/cloud_bag.h"
#include "drivers/file/file_list.h"
#include "drivers/file/format.h"
#include "drivers/file/playlist.h"
#include "drivers/file/ros_cloud.h"
#include "tools/mcap_open.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const struct dx_driver *dx_source_driver(const char *path)
{
    return dx_playlist_wants(path) ? &dx_recorded_driver : &dx_file_driver;
}

/* No file is MCAP; false also when there are none, which opening them tells. */
static bool is_all_scans(const char *path)
{
    struct dx_file_list list;
    bool is = true;

    if (dx_file_list_init(&list, path, NULL) != 0)
        return false;
    for (size_t k = 0; k < list.n && is; k++)
        is = !dx_cloud_bag_probe(list.paths[k]) && !dx_format_has_ext(list.paths[k], ".mcap");
    dx_file_list_fini(&list);
    return is;
}

int dx_source_check(const struct dx_file_config *c, const char *command)
{
    const char *option = c->fit.unit_m > 0  ? "a unit"
                         : c->fit.seam >= 0 ? "a seam"
                         : c->thin.width    ? "a size"
                         : c->exact         ? "--exact"
                         : c->topic         ? "--topic"
                                            : NULL;

    if (option && dx_playlist_wants(c->path)) {
        fprintf(stderr, "%s: found %s for the recording '%s', expected none: it has its own\n",
                command, option, c->path);
        return -EINVAL;
    }
    if (c->topic && is_all_scans(c->path)) {
        fprintf(stderr, "%s: --topic: found '%s' for the scans '%s', expected clouds in MCAP\n",
                command, c->topic, c->path);
        return -EINVAL;
    }
    return 0;
}

uint64_t dx_source_time(const struct dx_driver *driver, const struct dx_block *block)
{
    return driver == &dx_recorded_driver ? block->stamp.host_ns : block->stamp.device_ns;
}

/* ---- recordings ------------------------------------------------------------------------------
 */

struct dx_device {
    struct dx_playlist *list;
    struct dx_config config;
    const struct dx_driver *driver; /* that recorded */
    struct dx_device *decoder;
    struct dx_playlist_block block;
    bool begun;
    uint64_t n_damaged; /* blocks that could not be decoded */
};

static void tell(const char *text)
{
    fprintf(stderr, "dexel: %s\n", text);
}

static void recorded_close(struct dx_device *dev)
{
    if (!dev)
        return;
    if (dev->n_damaged > 1)
        fprintf(stderr, "dexel: %llu blocks could not be decoded\n",
                (unsigned long long)dev->n_damaged);
    if (dev->driver)
        dev->driver->close(dev->decoder);
    dx_config_fini(&dev->config);
    dx_playlist_free(dev->list);
    free(dev);
}

static int open_decoder(struct dx_device *dev, struct dx_err *err)
{
    size_t len;
    const char *text = dx_playlist_config(dev->list, &len);
    int rc = dx_config_parse(&dev->config, DX_RECORDING_CONFIG_NAME, text, len, err);

    if (rc)
        return rc;
    if (dev->config.n_streams != 1)
        return dx_err_set(err, -EBADMSG, "%s of %u streams, expected one", DX_RECORDING_CONFIG,
                          dev->config.n_streams);
    dev->driver = dx_driver_find(dev->config.streams[0].driver);
    return dev->driver->open_decoder(&dev->decoder, &dev->config.streams[0].source, err);
}

/* No scan is among the recordings: the first file has decided that they are some. */
static int check_alike(const char *path, struct dx_err *err)
{
    struct dx_file_list list;
    int rc = dx_file_list_init(&list, path, err);

    if (rc)
        return rc;
    for (size_t k = 0; k < list.n && rc == 0; k++)
        if (dx_format_knows_name(list.paths[k]) && !dx_format_has_ext(list.paths[k], ".mcap") &&
            !dx_cloud_bag_probe(list.paths[k]))
            rc = dx_err_set(err, -EBADMSG,
                            "%s: a scan among recordings, expected either in a folder",
                            list.paths[k]);
    dx_file_list_fini(&list);
    return rc;
}

/* A whole MCAP file of another program that has no clouds: what it is, in place of what it is not.
 */
static void explain(const char *path, struct dx_err *err)
{
    struct dx_mcap_file file;

    if (dx_mcap_file_open(&file, path, NULL, NULL) < 0)
        return;
    if (dx_mcap_reader_damages(file.reader) == 0 &&
        !dx_mcap_reader_topic(file.reader, DX_RECORDING_TOPIC) &&
        !dx_cloud_bag_has_clouds(file.reader))
        dx_err_set(err, 0,
                   "%s: neither a recording of dexeld nor clouds (" DX_ROS_CLOUD_NAME
                   " in CDR) are in it",
                   path);
    dx_mcap_file_close(&file);
}

static int recorded_open(struct dx_device **out, const void *config, struct dx_err *err)
{
    const struct dx_file_config *c = config;
    struct dx_device *dev = calloc(1, sizeof(*dev));
    int rc;

    if (!dev)
        return dx_err_set(err, -ENOMEM, "%s: no memory", c->path);
    rc = check_alike(c->path, err);
    if (rc == 0) {
        rc = dx_playlist_new(&dev->list, c->path, tell, err);
        if (rc == -EBADMSG)
            explain(c->path, err);
    }
    if (rc == 0) {
        rc = open_decoder(dev, err);
        if (rc)
            dx_err_prefix(err, c->path);
    }
    if (rc) {
        recorded_close(dev);
        return rc;
    }
    *out = dev;
    return 0;
}

static int recorded_start(struct dx_device *dev, struct dx_err *err)
{
    (void)dev;
    (void)err;
    return 0;
}

static void recorded_stop(struct dx_device *dev)
{
    (void)dev;
}

static int recorded_read(struct dx_device *dev, struct dx_block *block, struct dx_err *err)
{
    int rc = dx_playlist_next(dev->list, &dev->block, err);

    if (rc)
        return rc;
    *block = dev->block.block;
    block->stamp.host_ns = dev->block.log_time;
    return 0;
}

/* The first block of a recording that begins later than its device did needs the geometry of then.
 */
static int adopt(struct dx_device *dev, const struct dx_block *block,
                 const struct dx_frame_sink *sink, struct dx_err *err)
{
    struct dx_geometry *g;
    uint8_t attr_bytes;
    int rc;

    if (block->number == 0 || !dev->driver->adopt ||
        !dx_playlist_geometry(dev->list, dev->block.log_time, &g, &attr_bytes))
        return 0;
    rc = dev->driver->adopt(dev->decoder, g, attr_bytes, sink, err);
    dx_geometry_unref(g);
    return rc;
}

static int recorded_decode(struct dx_device *dev, const struct dx_block *block,
                           const struct dx_frame_sink *sink, struct dx_err *err)
{
    int rc = dev->begun ? 0 : adopt(dev, block, sink, err);

    dev->begun = true;
    if (rc == 0)
        rc = dev->driver->decode(dev->decoder, block, sink, err);
    if (rc != DX_DRIVER_E_CORRUPT)
        return rc;
    if (dev->n_damaged++ == 0)
        tell(err->text);
    return 0;
}

const struct dx_driver dx_recorded_driver = {
    .name = "recording",
    .open = recorded_open,
    .open_decoder = recorded_open,
    .start = recorded_start,
    .read = recorded_read,
    .decode = recorded_decode,
    .stop = recorded_stop,
    .close = recorded_close,
};

const struct dx_driver *dx_recorded_by(const struct dx_device *dev)
{
    return dev->driver;
}

const char *dx_recorded_stream(const struct dx_device *dev)
{
    return dev->config.streams[0].name;
}

const char *dx_recorded_config(const struct dx_device *dev, size_t *len)
{
    return dx_playlist_config(dev->list, len);
}

bool dx_recorded_starts_frame(const struct dx_device *dev)
{
    return dev->block.starts_frame;
}

const struct dx_fit_report *dx_source_fit_report(const struct dx_driver *driver,
                                                 const struct dx_device *dev)
{
    if (driver == &dx_recorded_driver) {
        driver = dev->driver;
        dev = dev->decoder;
    }
    return driver == &dx_file_driver ? dx_file_fit_report(dev) : NULL;
}
