/*
 * Writers of organized frames: PTX, one scan or several in a file, and binary PCD. The points are
 * those of the geometry (f32), the attribute becomes an intensity of 0..1. One thread's.
 */
#ifndef DX_OUT_FRAMES_H
#define DX_OUT_FRAMES_H

#include "core/grid/geometry.h"
#include "core/grid/plane.h"
#include "tools/out_file.h"

enum dx_frame_format { DX_FRAME_PTX, DX_FRAME_PCD };

/* NULL-terminated, by enum dx_frame_format: "ptx", "pcd". */
extern const char *const dx_frame_formats[];

/* Where frames go: a file, when the path ends in .ptx or .pcd, else a directory of frame-NNNNNN
 * files. */
struct dx_out_frames {
    char *path;
    enum dx_frame_format format;
    bool folder, made_folder;
    struct dx_out_file file; /* open between frames of one file */
    uint64_t n;              /* frames so far */
};

/* -EINVAL: a file in another format must be meant ("scan.pcd.gz"), not a directory of that name. */
int dx_out_frames_check(const char *path, struct dx_err *err);

/* `format` is for directories, which are made when missing. Errors: -errno, the path in the text.
 */
int dx_out_frames_open(struct dx_out_frames *o, const char *path, enum dx_frame_format format,
                       struct dx_err *err);

/* A second frame into one PCD file is -EINVAL. */
int dx_out_frames_add(struct dx_out_frames *o, const struct dx_plane *plane,
                      const struct dx_geometry *g, struct dx_err *err);

/* Puts the file in its place; no frames at all is -ENODATA. `o` is zeroed, whatever is returned. */
int dx_out_frames_commit(struct dx_out_frames *o, struct dx_err *err);

/* Takes the file back (complete ones of a directory stay). Zeroed is fine. */
void dx_out_frames_abort(struct dx_out_frames *o);

/* The formats themselves; errors of the stream show in ferror(). */
void dx_out_ptx(FILE *f, const struct dx_plane *plane, const struct dx_geometry *g);
void dx_out_pcd(FILE *f, const struct dx_plane *plane, const struct dx_geometry *g);

#endif
