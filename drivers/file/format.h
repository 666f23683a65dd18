/*
 * What a file format is to the file driver: it recognises its bytes, cuts a file into blocks of one
 * frame, and turns a block into organized points. Each format is one in_NAME.c that knows nothing
 * of the others.
 */
#ifndef DX_FORMAT_H
#define DX_FORMAT_H

#include "core/base/err.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Organized points of one frame, owned by the caller, reused from frame to frame. Row-major. */
struct dx_xyz_frame {
    uint32_t height, width;
    double *xyz;        /* NaN where there is no return; scanner frame, metres */
    uint16_t *attr;     /* NULL when the file has none */
    uint8_t attr_bytes; /* 1 or 2: the depth that the file's attribute has */
    double pose[12];    /* rows of [R|t], scanner to world */
    size_t cap_dexels;  /* room in xyz and attr */
    uint16_t *attr_room;
    float *intensity; /* scratch of decoders, for dx_xyz_frame_scale */
};

/* Sets the size and makes room; xyz is all NaN, the pose identity, without an attribute. -ENOMEM.
 */
int dx_xyz_frame_reserve(struct dx_xyz_frame *f, uint32_t height, uint32_t width);
void dx_xyz_frame_fini(struct dx_xyz_frame *f);

/* Sets a point; one that is all zero, or not finite, is no return. */
static inline void dx_xyz_frame_set(struct dx_xyz_frame *f, size_t k, double x, double y, double z)
{
    const bool is_return =
        isfinite(x) && isfinite(y) && isfinite(z) && (x != 0 || y != 0 || z != 0);
    double *p = f->xyz + 3 * k;

    p[0] = is_return ? x : NAN;
    p[1] = is_return ? y : NAN;
    p[2] = is_return ? z : NAN;
}

/*
 * Makes the 16-bit attribute of intensity[] (one per dexel). The scale is the narrowest of these
 * that holds all returns of the frame: 0..1 times 65535, 0..255 times 257, 0..65535 as it is;
 * others are stretched from their smallest to their largest. Not finite: 0.
 */
void dx_xyz_frame_scale(struct dx_xyz_frame *f);

struct dx_format {
    const char *name;
    const char *ext; /* of its files, ".ptx" */
    /* The first bytes (up to 4096, decompressed) look like this format. */
    bool (*probe)(const uint8_t *bytes, size_t len);
    /* Length of the frame that starts at bytes[0] (a PTX holds several scans). 0: no frame left
     * (blank space to the end). Negative: err. */
    int64_t (*block_len)(const uint8_t *bytes, size_t len, struct dx_err *err);
    /* One block to points. Errors name line or byte offset (of the block), what was found and
     * expected. */
    int (*decode)(struct dx_xyz_frame *out, const uint8_t *bytes, size_t len, struct dx_err *err);
};

extern const struct dx_format dx_format_ptx, dx_format_pcd, dx_format_ros;

/* decode() of PCD, for clouds of a single row as well: of any points. */
int dx_pcd_decode_any(struct dx_xyz_frame *out, const uint8_t *bytes, size_t len,
                      struct dx_err *err);

/* The format of these first bytes: by content, else by the name. NULL: neither. */
const struct dx_format *dx_format_find(const uint8_t *bytes, size_t len, const char *path);

/* The name ends in `ext` (".ptx"), or in it and ".gz"; letters of either case. */
bool dx_format_has_ext(const char *path, const char *ext);

/* The name is that of some format's files. */
bool dx_format_knows_name(const char *path);

/* May the file be a recording, by its name or else by how it begins? Yes as well when that cannot
 * be told without more ado: it is packed, or cannot be read. */
bool dx_format_may_be(const char *path);

#endif
