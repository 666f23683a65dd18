/* Recordings of a simulated stream, to be played: one device, which came back once. */
#ifndef PLAYED_FIXTURE_H
#define PLAYED_FIXTURE_H

#include "file_fixture.h"

#include "daemon/config.h"
#include "daemon/log.h"
#include "daemon/record_files.h"
#include "daemon/recorder.h"

#define YAML(seed)                                                                                 \
    "streams:\n"                                                                                   \
    "  - name: box\n"                                                                              \
    "    synthetic: {scene: moving-box, size: 32x24, noise: 0.002, parts: 8, rate: max,\n"         \
    "                frames: 20, seed: " #seed "}\n"

enum { FRAMES = 20, PARTS = 4, RETURN = 9 }; /* RETURN: frame at which the device came back */

static inline int create_file(void *ctx, struct dx_mcap_sink *sink, const char **path,
                              uint64_t unix_ns)
{
    struct dx_record_files *f = ctx;
    int rc = dx_record_files_create(f, unix_ns);

    *path = f->path;
    *sink = dx_mcap_sink_fd(f->fd);
    return rc;
}

static inline int sync_file(void *ctx)
{
    return dx_record_files_sync(ctx);
}

static inline void close_file(void *ctx)
{
    dx_record_files_close(ctx);
}

/* Frames 0.25 s apart into FOLDER/NAME: a chunk holds four of them. */
static inline void record(const char *folder, const char *name, const char *yaml, uint64_t split_ns)
{
    char *pattern = path_in(folder, name);
    struct dx_record_files files;
    struct dx_recorder_config c = {.name = "box",
                                   .driver = "synthetic",
                                   .yaml = yaml,
                                   .yaml_len = strlen(yaml),
                                   .store = {&files, create_file, sync_file, close_file},
                                   .ring_len = 1 << 20,
                                   .compression = DX_MCAP_ZSTD,
                                   .split_ns = split_ns,
                                   .start = true};
    struct dx_device *dev = NULL;
    struct dx_recorder *r = NULL;
    struct dx_config config;
    struct dx_block block;
    struct dx_err err;

    dx_log_set_level(-1);
    dx_record_files_init(&files, pattern, 0);
    assert_int_equal(dx_config_parse(&config, "t", yaml, strlen(yaml), &err), 0);
    assert_int_equal(dx_synth_driver.open(&dev, &config.streams[0].source, &err), 0);
    assert_int_equal(dx_synth_driver.start(dev, &err), 0);
    assert_int_equal(dx_recorder_new(&r, &c, &err), 0);
    while (dx_synth_driver.read(dev, &block, &err) == 0) {
        block.stamp.host_ns = 1000000000u + block.number * (250000000u / PARTS);
        block.first = block.number == 0 || block.number == RETURN * PARTS;
        dx_recorder_feed(r, &block, block.number % PARTS == 0);
    }
    dx_recorder_stop(r, true);
    dx_recorder_run(r);
    dx_recorder_free(r);
    dx_synth_driver.close(dev);
    dx_config_fini(&config);
    free(pattern);
}

#endif
