/*
 * A file from outside, of any kind that is read, by the ways that a user gives one: told about,
 * read as points, and played as a recording. Beside the targets of the formats it covers what goes
 * before and after them: gzip, names, lists of files, the configuration in a recording, its blocks
 * put together, and the drivers that decode them.
 *
 * Input: a byte for the name, then the file.
 */
#include "daemon/log.h"
#include "daemon/player.h"
#include "drivers/file/file.h"
#include "tools/cloud_read.h"
#include "tools/cmd.h"

#include <fcntl.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

#define MAX_BLOCKS 64

static char dir[] = "/tmp/dexeld-fuzz-XXXXXX", path[64];

static void start(void)
{
    dx_log_set_level(-1); /* what is told of the file is not for us */
    stdout = stderr = fopen("/dev/null", "w");
    if (!stdout || !mkdtemp(dir))
        abort();
}

static void clean(void)
{
    unlink(path);
    rmdir(dir);
}

static void write_file(const char *name, const uint8_t *bytes, size_t len)
{
    int fd;

    unlink(path);
    snprintf(path, sizeof(path), "%s/%s", dir, name);
    fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (fd < 0 || write(fd, bytes, len) != (ssize_t)len)
        abort();
    close(fd);
}

static void tell(char *option)
{
    char command[] = "dexel info";

    optind = 0; /* glibc's getopt begins anew */
    cmd_info(3, (char *[]){command, option, path, NULL});
}

static void read_points(void)
{
    struct dx_point_list list = {0};
    struct dx_err err;

    dx_cloud_read(&list, &(struct dx_cloud_source){.path = path, .frame = DX_CLOUD_READ_ALL}, &err);
    dx_point_list_fini(&list);
}

/* ---- played -----------------------------------------------------------------------------------
 */

static int on_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct dx_plane *plane = ctx;

    dx_plane_fini(plane);
    *plane = (struct dx_plane){0};
    return dx_plane_init_for(plane, g, attr_bytes);
}

static struct dx_plane *on_plane(void *ctx, uint64_t number)
{
    struct dx_plane *plane = ctx;

    (void)number;
    return plane->width ? plane : NULL;
}

static void on_deliver(void *ctx, const struct dx_frame_part *part)
{
    const struct dx_plane *plane = ctx;

    if (part->n_cols == 0 || part->col0 + part->n_cols > plane->width)
        abort();
}

static void play(void)
{
    const struct dx_file_config config = {.path = path, .attr_bytes = -1, .fit.seam = -1};
    struct dx_plane plane = {0};
    const struct dx_frame_sink sink = {&plane, on_geometry, on_plane, on_deliver};
    struct dx_device *dev = NULL;
    struct dx_block block;
    struct dx_err err;
    int rc;

    if (dx_player_driver.open(&dev, &config, &err) != 0)
        return;
    rc = dx_player_driver.start(dev, &err);
    for (int k = 0; rc == 0 && k < MAX_BLOCKS; k++) {
        rc = dx_player_driver.read(dev, &block, &err);
        if (rc == 0)
            rc = dx_player_driver.decode(dev, &block, &sink, &err);
        if (rc == DX_DRIVER_E_CORRUPT || rc == DX_DRIVER_E_AGAIN)
            rc = 0;
        if (k == MAX_BLOCKS / 2)
            dx_player_seek(dev, 0);
    }
    dx_player_driver.stop(dev);
    dx_player_driver.close(dev);
    dx_plane_fini(&plane);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    static const char *const names[] = {"a.mcap", "a.pcd",    "a.ptx", "a.xyz", "a.ply",
                                        "a.pts",  "a.pcd.gz", "a.stl", "a.obj", "a"};
    static char json[] = "--json", quick[] = "--quick";

    if (len < 1)
        return 0;
    if (!*path) {
        start();
        atexit(clean);
    }
    write_file(names[bytes[0] % (sizeof(names) / sizeof(*names))], bytes + 1, len - 1);
    tell(json);
    tell(quick);
    read_points();
    play();
    return 0;
}
