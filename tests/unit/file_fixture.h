/*
 * For tests of the file driver and its formats: temporary folders and files, a sink that keeps what
 * it is given, and text being built.
 */
#ifndef DX_FILE_FIXTURE_H
#define DX_FILE_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <zlib.h>

#include "core/base/trig.h"
#include "drivers/file/file.h"
#include "drivers/file/format.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- bytes being built ------------------------------------------------------------------------
 */

struct buffer {
    uint8_t *bytes;
    size_t len;
};

static inline void buffer_add(struct buffer *b, const void *bytes, size_t len)
{
    b->bytes = realloc(b->bytes, b->len + len + 1);
    assert_non_null(b->bytes);
    memcpy(b->bytes + b->len, bytes, len);
    b->len += len;
    b->bytes[b->len] = 0;
}

__attribute__((format(printf, 2, 3))) static inline void buffer_print(struct buffer *b,
                                                                      const char *format, ...)
{
    char text[1024];
    va_list ap;
    int n;

    va_start(ap, format);
    n = vsnprintf(text, sizeof(text), format, ap);
    va_end(ap);
    assert_in_range(n, 0, sizeof(text) - 1);
    buffer_add(b, text, (size_t)n);
}

static inline void buffer_fini(struct buffer *b)
{
    free(b->bytes);
    *b = (struct buffer){0};
}

/* A copy without a byte to spare, so that the address sanitizer sees each read beyond. */
static inline uint8_t *exact_copy(const void *bytes, size_t len)
{
    uint8_t *copy = malloc(len ? len : 1);

    assert_non_null(copy);
    if (len)
        memcpy(copy, bytes, len);
    return copy;
}

/* ---- files ------------------------------------------------------------------------------------
 */

static inline char *make_folder(void)
{
    char *path = strdup("/tmp/dexeld-test-XXXXXX");

    assert_non_null(path);
    assert_non_null(mkdtemp(path));
    return path;
}

static inline char *path_in(const char *folder, const char *name)
{
    char *path = NULL;

    assert_true(asprintf(&path, "%s/%s", folder, name) > 0);
    return path;
}

static inline void write_file(const char *folder, const char *name, const void *bytes, size_t len)
{
    char *path = path_in(folder, name);
    FILE *f = fopen(path, "wb");

    assert_non_null(f);
    assert_int_equal(fwrite(bytes, 1, len, f), len);
    assert_int_equal(fclose(f), 0);
    free(path);
}

/* To be opened by a careless reader, and never to be read. */
static inline void make_fifo(const char *folder, const char *name)
{
    char *path = path_in(folder, name);

    assert_int_equal(mkfifo(path, 0600), 0);
    free(path);
}

/* Removes a folder of plain files. */
static inline void remove_folder(char *folder)
{
    char command[128];

    snprintf(command, sizeof(command), "rm -r %s", folder);
    assert_int_equal(system(command), 0);
    free(folder);
}

/* ---- a sink -----------------------------------------------------------------------------------
 */

struct kept {
    struct dx_geometry *geometry;
    uint8_t attr_bytes;
    unsigned n_geometries, n_frames;
    struct dx_plane plane;
    struct dx_frame_part part; /* the last one */
    bool closing;
    int refuse; /* what geometry() returns */
};

static inline int kept_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct kept *k = ctx;

    if (k->refuse)
        return k->refuse;
    dx_geometry_unref(k->geometry);
    k->geometry = dx_geometry_ref(g);
    k->attr_bytes = attr_bytes;
    k->n_geometries++;
    dx_plane_fini(&k->plane);
    return dx_plane_init_for(&k->plane, g, attr_bytes);
}

static inline struct dx_plane *kept_plane(void *ctx, uint64_t number)
{
    struct kept *k = ctx;

    (void)number;
    return k->closing ? NULL : &k->plane;
}

static inline void kept_deliver(void *ctx, const struct dx_frame_part *part)
{
    struct kept *k = ctx;

    k->part = *part;
    k->n_frames++;
}

static inline struct dx_frame_sink sink_to(struct kept *k)
{
    return (struct dx_frame_sink){k, kept_geometry, kept_plane, kept_deliver};
}

static inline void kept_fini(struct kept *k)
{
    dx_geometry_unref(k->geometry);
    dx_plane_fini(&k->plane);
    *k = (struct kept){0};
}

static inline struct dx_file_config file_config(const char *path)
{
    return (struct dx_file_config){.path = path, .attr_bytes = -1, .fit = {.seam = -1}};
}

/* Reads and decodes one block; the result of what failed first. */
static inline int step(struct dx_device *dev, struct kept *k, struct dx_err *err)
{
    struct dx_frame_sink sink = sink_to(k);
    struct dx_block block;
    int rc = dx_file_driver.read(dev, &block, err);

    return rc ? rc : dx_file_driver.decode(dev, &block, &sink, err);
}

/* A file of the collection of real scans, or NULL when it is not there. */
static inline char *real_file(const char *name)
{
    const char *folder = getenv("DEXEL_DATA");
    char *path = folder ? path_in(folder, name) : NULL;

    if (path && access(path, R_OK) != 0) {
        free(path);
        path = NULL;
    }
    return path;
}

static inline struct buffer gzipped(const struct buffer *plain)
{
    z_stream z = {0};
    struct buffer out = {0};
    uint8_t room[65536];

    assert_int_equal(deflateInit2(&z, 6, Z_DEFLATED, 31, 8, Z_DEFAULT_STRATEGY), Z_OK);
    z.next_in = plain->bytes;
    z.avail_in = (uInt)plain->len;
    z.next_out = room;
    z.avail_out = sizeof(room);
    assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
    buffer_add(&out, room, sizeof(room) - z.avail_out);
    deflateEnd(&z);
    return out;
}

#define HEADER "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n%g 0 0 1\n"
enum { COLS = 12, ROWS = 5 };

/* A spinning scan as PTX: `shift` turns it (in columns), `range` in metres, `x` the scanner's
 * place. */
static inline void add_scan(struct buffer *b, double shift, double range, double x)
{
    buffer_print(b, "%d\n%d\n" HEADER, COLS, ROWS, x);
    for (int col = 0; col < COLS; col++)
        for (int row = 0; row < ROWS; row++) {
            double a = dx_rad((col + shift) * 30), e = dx_rad(-20 + 10 * row);

            buffer_print(b, "%.9f %.9f %.9f %g\n", range * dx_cos(e) * dx_cos(a),
                         range * dx_cos(e) * dx_sin(a), range * dx_sin(e), row / 4.0);
        }
}

static inline void write_scan(const char *folder, const char *name, double shift, double range,
                              double x)
{
    struct buffer b = {0};

    add_scan(&b, shift, range, x);
    write_file(folder, name, b.bytes, b.len);
    buffer_fini(&b);
}

static inline struct dx_device *open_device(const struct dx_file_config *config)
{
    struct dx_device *dev = NULL;
    struct dx_err err = {""};

    if (dx_file_driver.open(&dev, config, &err))
        fail_msg("%s", err.text);
    assert_int_equal(dx_file_driver.start(dev, &err), 0);
    return dev;
}

static inline struct dx_device *open_path(const char *folder, const char *name)
{
    char *path = path_in(folder, name);
    struct dx_file_config config = file_config(path);
    struct dx_device *dev = open_device(&config);

    free(path); /* the device keeps what it needs */
    return dev;
}

static inline void close_device(struct dx_device *dev)
{
    dx_file_driver.stop(dev);
    dx_file_driver.close(dev);
}

static inline void expect_step(struct dx_device *dev, struct kept *k, int want, const char *message)
{
    struct dx_err err = {""};
    int rc = step(dev, k, &err);

    if (rc != want || !strstr(err.text, message))
        fail_msg("%d \"%s\", expected %d \"%s\"", rc, err.text, want, message);
}

#endif
