/* Files, directories and their names; the formats are in out_scan.c. */
#include "tools/out_frames.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

const char *const dx_frame_formats[] = {[DX_FRAME_PTX] = "ptx", [DX_FRAME_PCD] = "pcd", NULL};

/* By the name's end; -1: a directory. */
static int format_of(const char *path)
{
    const char *dot = strrchr(path, '.');

    for (int k = 0; dot && dx_frame_formats[k]; k++)
        if (strcmp(dot + 1, dx_frame_formats[k]) == 0)
            return k;
    return -1;
}

/* After the last slash that something follows. */
static bool has_dot(const char *path)
{
    size_t end = strlen(path);

    while (end > 0 && path[end - 1] == '/')
        end--;
    while (end > 0 && path[end - 1] != '/')
        if (path[--end] == '.')
            return true;
    return false;
}

int dx_out_frames_check(const char *path, struct dx_err *err)
{
    struct stat st;

    if (format_of(path) >= 0 || !has_dot(path) || (stat(path, &st) == 0 && S_ISDIR(st.st_mode)))
        return 0;
    return dx_err_set(err, -EINVAL,
                      "found '%s', expected a name ending in .ptx or .pcd, or a folder (without a "
                      "dot in its name, or one that exists)",
                      path);
}

static int open_folder(struct dx_out_frames *o, struct dx_err *err)
{
    struct stat st;

    if (mkdir(o->path, 0777) == 0) {
        o->made_folder = true;
        return 0;
    }
    if (errno != EEXIST)
        return dx_err_set(err, -errno, "%s: cannot make the directory: %s", o->path,
                          strerror(errno));
    if (stat(o->path, &st) < 0 || !S_ISDIR(st.st_mode))
        return dx_err_set(err, -ENOTDIR,
                          "%s: a file is there, expected a directory or a name in .ptx or .pcd",
                          o->path);
    return 0;
}

int dx_out_frames_open(struct dx_out_frames *o, const char *path, enum dx_frame_format format,
                       struct dx_err *err)
{
    int by_name = format_of(path), r;

    *o = (struct dx_out_frames){.path = strdup(path), .format = format, .folder = by_name < 0};
    if (!o->path)
        return dx_err_set(err, -ENOMEM, "%s: out of memory", path);
    if (!o->folder)
        o->format = (enum dx_frame_format)by_name;
    r = o->folder ? open_folder(o, err) : dx_out_file_open(&o->file, path, err);
    if (r < 0)
        dx_out_frames_abort(o);
    return r;
}

static int open_frame(struct dx_out_frames *o, struct dx_err *err)
{
    char *path;
    int r;

    if (asprintf(&path, "%s/frame-%06llu.%s", o->path, (unsigned long long)o->n,
                 dx_frame_formats[o->format]) < 0)
        return dx_err_set(err, -ENOMEM, "%s: out of memory", o->path);
    r = dx_out_file_open(&o->file, path, err);
    free(path);
    return r;
}

int dx_out_frames_add(struct dx_out_frames *o, const struct dx_plane *plane,
                      const struct dx_geometry *g, struct dx_err *err)
{
    int r = 0;

    if (!o->folder && o->format == DX_FRAME_PCD && o->n > 0)
        return dx_err_set(err, -EINVAL,
                          "%s: PCD holds one frame, found another; expected a directory or .ptx",
                          o->path);
    if (o->folder)
        r = open_frame(o, err);
    if (r < 0)
        return r;
    if (o->format == DX_FRAME_PTX)
        dx_out_ptx(o->file.stream, plane, g);
    else
        dx_out_pcd(o->file.stream, plane, g);
    if (o->folder)
        r = dx_out_file_commit(&o->file, err);
    else if (ferror(o->file.stream)) /* now, not after the other frames */
        r = dx_err_set(err, -EIO, "%s: cannot be written: %s", o->path, strerror(errno));
    if (r == 0)
        o->n++;
    return r;
}

int dx_out_frames_commit(struct dx_out_frames *o, struct dx_err *err)
{
    int r = 0;

    if (o->n == 0)
        r = dx_err_set(err, -ENODATA, "%s: not written: no frames", o->path);
    else if (!o->folder)
        r = dx_out_file_commit(&o->file, err);
    dx_out_frames_abort(o);
    return r;
}

void dx_out_frames_abort(struct dx_out_frames *o)
{
    dx_out_file_abort(&o->file);
    if (o->made_folder && o->n == 0)
        rmdir(o->path);
    free(o->path);
    *o = (struct dx_out_frames){0};
}
