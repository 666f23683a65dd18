/* The loop that reads blocks and decodes them, and where they and their frames go. */
#include "tools/convert.h"

#include "daemon/config.h"
#include "tools/out_recording.h"
#include "tools/source.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

struct convert {
    const struct dx_convert_config *config;
    const struct dx_driver *driver;
    struct dx_device *dev;

    /* the sink */
    struct dx_geometry *g;
    struct dx_plane plane;
    uint64_t number;   /* of the frame in `plane` */
    bool filling;      /* it is not whole yet */
    uint64_t n_frames; /* whole ones so far */
    uint64_t time;     /* of the block under way */

    /* one of these is open */
    struct dx_out_frames frames;
    struct dx_out_recording recording;
    struct dx_out_ros ros;

    struct dx_err *err;
    int failed; /* what writing returned: deliver cannot */
};

/* ---- where it goes ---------------------------------------------------------------------------
 */

enum target { SCANS, RECORDING, ROS };

bool dx_convert_is_mcap(const char *out)
{
    const char *dot = strrchr(out, '.');

    return dot && strcmp(dot, ".mcap") == 0;
}

static enum target target_of(const struct dx_convert_config *c)
{
    return !dx_convert_is_mcap(c->out) ? SCANS : c->ros == DX_ROS_NONE ? RECORDING : ROS;
}

static bool is_wanted(const struct convert *c)
{
    return c->config->frame == DX_CONVERT_ALL || c->config->frame == c->n_frames;
}

/* A configuration that decodes these scans as they are decoded here; its text is the caller's. */
static int scan_text(char **text, size_t *len, const struct dx_convert_config *c,
                     struct dx_err *err)
{
    const struct dx_config_replay replay = {.path = c->source.path, .socket = "-", .rate = "max"};
    struct dx_file_config *file;
    struct dx_config config;
    int rc = dx_config_for_replay(&config, &replay, err);

    if (rc)
        return rc;
    file = &config.streams[0].source.file;
    file->fit = c->source.fit;
    file->thin = c->source.thin;
    file->exact = c->source.exact;
    rc = dx_config_stream_text(text, len, &config.streams[0]);
    dx_config_fini(&config);
    return rc ? dx_err_set(err, rc, "%s: %s", DX_RECORDING_CONFIG, strerror(-rc)) : 0;
}

/* A recording stays that of its stream; scans become one of a stream "replay", as the service would
 * have replayed them. */
static int open_recording(struct convert *c)
{
    struct dx_out_recording_of of = {.driver = dx_file_driver.name, .stream = "replay"};
    char *text = NULL;
    int rc = 0;

    if (c->driver == &dx_recorded_driver) {
        of.driver = dx_recorded_by(c->dev)->name;
        of.stream = dx_recorded_stream(c->dev);
        of.yaml = dx_recorded_config(c->dev, &of.yaml_len);
    } else {
        rc = scan_text(&text, &of.yaml_len, c->config, c->err);
        of.yaml = text;
    }
    if (rc == 0)
        rc = dx_out_recording_open(&c->recording, c->config->out, &of, c->err);
    free(text);
    return rc;
}

static int open_target(struct convert *c)
{
    const struct dx_convert_config *config = c->config;

    switch (target_of(config)) {
    case RECORDING:
        return open_recording(c);
    case ROS:
        return dx_out_ros_open(&c->ros, config->out, config->ros, &config->terrain, c->err);
    case SCANS:
        break;
    }
    return dx_out_frames_open(&c->frames, config->out, config->format, c->err);
}

static int commit(struct convert *c)
{
    switch (target_of(c->config)) {
    case RECORDING:
        return dx_out_recording_commit(&c->recording, c->err);
    case ROS:
        return dx_out_ros_commit(&c->ros, c->err);
    case SCANS:
        break;
    }
    return dx_out_frames_commit(&c->frames, c->err);
}

static void abort_all(struct convert *c)
{
    dx_out_frames_abort(&c->frames);
    dx_out_recording_abort(&c->recording);
    dx_out_ros_abort(&c->ros);
}

/* ---- the sink --------------------------------------------------------------------------------
 */

static int on_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct convert *c = ctx;
    int rc;

    dx_plane_fini(&c->plane);
    c->filling = false;
    rc = dx_plane_init_for(&c->plane, g, attr_bytes);
    if (rc < 0)
        return dx_err_set(c->err, rc, "%ux%u: %s", g->width, g->height, strerror(-rc));
    dx_geometry_unref(c->g);
    c->g = dx_geometry_ref(g);
    if (target_of(c->config) == RECORDING)
        return dx_out_recording_geometry(&c->recording, g, attr_bytes, c->time, c->err);
    return target_of(c->config) == ROS ? dx_out_ros_geometry(&c->ros, g, attr_bytes, c->err) : 0;
}

static struct dx_plane *on_plane(void *ctx, uint64_t number)
{
    struct convert *c = ctx;

    if (!c->g)
        return NULL;
    if (!c->filling || number != c->number) {
        dx_plane_clear(&c->plane);
        c->number = number;
        c->filling = true;
    }
    return &c->plane;
}

static void on_deliver(void *ctx, const struct dx_frame_part *part)
{
    struct convert *c = ctx;

    if (!part->last)
        return;
    if (is_wanted(c) && c->failed == 0) {
        if (target_of(c->config) == SCANS)
            c->failed = dx_out_frames_add(&c->frames, &c->plane, c->g, c->err);
        else if (target_of(c->config) == ROS)
            c->failed = dx_out_ros_add(&c->ros, &c->plane, c->g, c->time, c->err);
    }
    c->filling = false;
    c->n_frames++;
}

/* ---- blocks ----------------------------------------------------------------------------------
 */

/* Scans are a frame a block. */
static bool starts_frame(const struct convert *c)
{
    return c->driver != &dx_recorded_driver || dx_recorded_starts_frame(c->dev);
}

/* Every frame; a damaged one ends it, since a sequence with holes is not what was asked for. */
static int copy(struct convert *c)
{
    const struct dx_frame_sink sink = {c, on_geometry, on_plane, on_deliver};
    struct dx_block block;
    int rc = 0;

    while (rc == 0 && (c->config->frame == DX_CONVERT_ALL || c->n_frames <= c->config->frame)) {
        rc = c->driver->read(c->dev, &block, c->err);
        if (rc == DX_DRIVER_E_EOF)
            break;
        if (rc)
            return rc < 0 ? rc : -EBADMSG;
        c->time = dx_source_time(c->driver, &block);
        if (target_of(c->config) == RECORDING && is_wanted(c))
            rc = dx_out_recording_add(&c->recording, &block, starts_frame(c), c->time, c->err);
        if (rc == 0)
            rc = c->driver->decode(c->dev, &block, &sink, c->err);
        if (rc == 0)
            rc = c->failed;
    }
    if (rc == DX_DRIVER_E_EOF && c->config->frame != DX_CONVERT_ALL)
        return dx_err_set(c->err, -ENODATA, "%s: found %llu frames, expected one of number %llu",
                          c->config->source.path, (unsigned long long)c->n_frames,
                          (unsigned long long)c->config->frame);
    return rc == DX_DRIVER_E_EOF ? 0 : rc > 0 ? -EBADMSG : rc;
}

/* Of a recording that is copied whole: of a frame there is nothing that could be missing. */
static bool keeps_gaps(const struct convert *c)
{
    return target_of(c->config) == RECORDING && c->driver == &dx_recorded_driver &&
           c->config->frame == DX_CONVERT_ALL;
}

static int run(struct convert *c)
{
    int rc = c->driver->start(c->dev, c->err);

    if (rc == 0)
        rc = open_target(c);
    if (rc == 0) {
        rc = copy(c);
        if (rc == 0 && keeps_gaps(c))
            rc = dx_out_recording_copy_gaps(&c->recording, c->config->source.path, c->err);
        rc = rc == 0 ? commit(c) : rc;
        c->driver->stop(c->dev);
    }
    return rc;
}

int dx_convert_run(const struct dx_convert_config *config, struct dx_err *err)
{
    struct convert c = {
        .config = config, .driver = dx_source_driver(config->source.path), .err = err};
    int rc = c.driver->open(&c.dev, &config->source, err);

    if (rc)
        return rc < 0 ? rc : -EBADMSG;
    rc = run(&c);
    abort_all(&c);
    c.driver->close(c.dev);
    dx_plane_fini(&c.plane);
    dx_geometry_unref(c.g);
    return rc;
}
