/* One loop over the points for all forms; a point without a normal has zeros in PLY and XYZ, and in
 * PCD, as usual there, what is no number. */
#include "tools/out_points.h"

#include "core/base/bytes.h"
#include "tools/out_file.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define MOST_LEN (3 * 8 + 4 * 4) /* bytes of a point */

enum form { PLY, PCD, XYZ, N_FORMS };

static const char *const endings[N_FORMS] = {".ply", ".pcd", ".xyz"};

static enum form form_of(const char *path)
{
    const char *dot = strrchr(path, '.');
    int form = 0;

    while (form < N_FORMS && (!dot || strcmp(dot, endings[form]) != 0))
        form++;
    return (enum form)form;
}

int dx_out_points_check(const char *path, struct dx_err *err)
{
    if (form_of(path) == N_FORMS)
        return dx_err_set(err, -EINVAL, "found '%s', expected a name ending in .ply, .pcd or .xyz",
                          path);
    return 0;
}

/* Far from the origin the steps of a float are larger than what tells points apart. */
static bool need_doubles(const struct dx_out_points *p)
{
    double low[3] = {0}, high[3] = {0}, extent = 0, off = 0;

    for (size_t i = 0; i < 3 * p->n; i++) {
        const double x = p->xyz[i], d = fabs(x - (double)(float)x);

        off = d > off ? d : off;
        low[i % 3] = i < 3 || x < low[i % 3] ? x : low[i % 3];
        high[i % 3] = i < 3 || x > high[i % 3] ? x : high[i % 3];
    }
    for (int k = 0; k < 3 && p->n; k++)
        extent = high[k] - low[k] > extent ? high[k] - low[k] : extent;
    return off > extent * 0x1p-24;
}

static void put_ply_header(FILE *f, const struct dx_out_points *p, bool ascii, bool doubles)
{
    const char *real = doubles ? "double" : "float";

    fprintf(f, "ply\nformat %s 1.0\ncomment dexel " DEXELD_VERSION "\n",
            ascii ? "ascii" : "binary_little_endian");
    fprintf(f, "element vertex %zu\nproperty %s x\nproperty %s y\nproperty %s z\n", p->n, real,
            real, real);
    fprintf(f, "property float nx\nproperty float ny\nproperty float nz\n"
               "property float curvature\nend_header\n");
}

static void put_pcd_header(FILE *f, const struct dx_out_points *p, bool ascii, bool doubles)
{
    const int len = doubles ? 8 : 4;

    fprintf(f,
            "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
            "FIELDS x y z normal_x normal_y normal_z curvature\n"
            "SIZE %d %d %d 4 4 4 4\nTYPE F F F F F F F\nCOUNT 1 1 1 1 1 1 1\n"
            "WIDTH %zu\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS %zu\nDATA %s\n",
            len, len, len, p->n, p->n, ascii ? "ascii" : "binary");
}

static void put_text(FILE *f, const double xyz[3], const float n[4], enum form form, bool doubles)
{
    fprintf(f, doubles ? "%.17g %.17g %.17g" : "%.9g %.9g %.9g", xyz[0], xyz[1], xyz[2]);
    for (int k = 0; k < (form == XYZ ? 3 : 4); k++)
        if (isfinite(n[k]))
            fprintf(f, " %.9g", (double)n[k]);
        else
            fputs(" nan", f);
    fputc('\n', f);
}

static void put_bytes(FILE *f, const double xyz[3], const float n[4], bool doubles)
{
    uint8_t record[MOST_LEN];
    struct dx_writer w = dx_writer_init(record, sizeof(record));

    for (int k = 0; k < 3; k++) {
        if (doubles)
            dx_write_f64(&w, xyz[k]);
        else
            dx_write_f32(&w, (float)xyz[k]);
    }
    for (int k = 0; k < 4; k++)
        dx_write_f32(&w, n[k]);
    fwrite(record, 1, (size_t)(w.p - record), f);
}

static void put_points(FILE *f, const struct dx_out_points *p, enum form form, bool ascii,
                       bool doubles)
{
    for (size_t i = 0; i < p->n; i++) {
        float n[4] = {p->normal[i][0], p->normal[i][1], p->normal[i][2],
                      p->curvature ? p->curvature[i] : 0};

        if (form == PCD && n[0] == 0 && n[1] == 0 && n[2] == 0)
            n[0] = n[1] = n[2] = n[3] = NAN;
        if (ascii || form == XYZ)
            put_text(f, p->xyz + 3 * i, n, form, doubles);
        else
            put_bytes(f, p->xyz + 3 * i, n, doubles);
    }
}

int dx_out_points(const char *path, const struct dx_out_points *points, bool ascii,
                  struct dx_err *err)
{
    const enum form form = form_of(path);
    const bool doubles = need_doubles(points);
    struct dx_out_file f;
    int rc = dx_out_points_check(path, err);

    if (rc == 0)
        rc = dx_out_file_open(&f, path, err);
    if (rc < 0)
        return rc;
    if (form == PLY)
        put_ply_header(f.stream, points, ascii, doubles);
    if (form == PCD)
        put_pcd_header(f.stream, points, ascii, doubles);
    put_points(f.stream, points, form, ascii, doubles);
    return dx_out_file_commit(&f, err);
}
