/*
 * PTX (Leica): text, scans one after the other. Each has the number of columns, the number of rows,
 * the scanner's position (1 line) and axes (3), a 4x4 matrix (4), then a line per point, column by
 * column: x y z [intensity] [r g b] [nx ny nz] in the scanner's frame, metres; 0 0 0 is no return.
 * world = [x y z 1] M. The position and axes repeat what M says and are not used. Colours and
 * normals are read and dropped.
 */
#include "drivers/file/format.h"

#include "core/grid/plane.h"
#include "drivers/file/text_cursor.h"

#include <errno.h>
#include <math.h>

#define MAX_FIELDS    10
#define MIN_POINT_LEN 6 /* "0 0 0\n"; the last line may lack its end */

struct ptx_header {
    uint32_t cols, rows;
    double matrix[16];
};

static int read_count(struct dx_text_cursor *c, uint32_t *out, const char *what)
{
    int rc = dx_text_count(c, out, DX_PLANE_MAX_SIDE, what);

    return rc ? rc : dx_text_end_line(c);
}

/* `n` finite numbers, a whole line. */
static int read_numbers(struct dx_text_cursor *c, double *out, int n, const char *what)
{
    for (int k = 0; k < n; k++) {
        const char *p = c->p;
        int rc = dx_text_number(c, &out[k], what);

        if (rc)
            return rc;
        if (!isfinite(out[k]))
            return dx_text_error(c, dx_number_skip_blank(p, c->end), what);
    }
    return dx_text_end_line(c);
}

static int read_header(struct dx_text_cursor *c, struct ptx_header *h)
{
    double unused[3];
    size_t left;
    int rc;

    dx_text_skip_blank_lines(c);
    rc = read_count(c, &h->cols, "a number of columns, 1 to 65535");
    if (rc == 0)
        rc = read_count(c, &h->rows, "a number of rows, 1 to 65535");
    for (int k = 0; k < 4 && rc == 0; k++)
        rc = read_numbers(c, unused, 3, "3 numbers (scanner position or axis)");
    for (int k = 0; k < 4 && rc == 0; k++)
        rc = read_numbers(c, h->matrix + 4 * k, 4, "4 numbers (row of the matrix)");
    if (rc)
        return rc;
    left = (size_t)(c->end - c->p);
    if ((uint64_t)h->cols * h->rows > DX_PLANE_MAX_DEXELS ||
        (uint64_t)h->cols * h->rows > (left + 1) / MIN_POINT_LEN)
        return dx_err_set(c->err, -EBADMSG,
                          "line %llu: %zu bytes are left, expected %u x %u points",
                          (unsigned long long)c->line, left, h->cols, h->rows);
    return 0;
}

/* The numbers of a point's line; the count of them, or negative. */
static int read_point(struct dx_text_cursor *c, double v[MAX_FIELDS])
{
    int n = 0;

    while (dx_text_next_word(c)) {
        int rc = n < MAX_FIELDS ? dx_text_number(c, &v[n], "a number")
                                : dx_text_error(c, c->p, "at most 10 numbers");

        if (rc)
            return rc;
        n++;
    }
    if (n < 3)
        return dx_text_error(c, c->p, "x y z");
    dx_text_end_line(c);
    return n;
}

/* Points come column by column, the frame is row by row. */
static int read_points(struct dx_text_cursor *c, const struct ptx_header *h,
                       struct dx_xyz_frame *out)
{
    double v[MAX_FIELDS] = {0};
    int n_fields = 0;

    for (uint32_t col = 0; col < h->cols; col++)
        for (uint32_t row = 0; row < h->rows; row++) {
            size_t k = (size_t)row * h->cols + col;
            int n = read_point(c, v);

            if (n < 0)
                return n;
            dx_xyz_frame_set(out, k, v[0], v[1], v[2]);
            out->intensity[k] = n >= 4 && fabs(v[3]) < 1e30 ? (float)v[3] : 0;
            /* some writers cut the lines of points without a return */
            if (isnan(out->xyz[3 * k]))
                continue;
            if (n_fields == 0)
                n_fields = n;
            if (n != n_fields)
                return dx_err_set(c->err, -EBADMSG,
                                  "line %llu: %d numbers, expected %d as in the points before",
                                  (unsigned long long)c->line - 1, n, n_fields);
        }
    if (n_fields >= 4 && n_fields != 6)
        dx_xyz_frame_scale(out);
    return 0;
}

/* Rows of [R|t] from a matrix for row vectors. */
static void set_pose(double pose[12], const double m[16])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            pose[4 * i + j] = m[4 * j + i];
}

static bool ptx_probe(const uint8_t *bytes, size_t len)
{
    struct dx_text_cursor c = dx_text_cursor_init(bytes, len, NULL);
    uint32_t cols, rows;
    double v[3];

    dx_text_skip_blank_lines(&c);
    return read_count(&c, &cols, "") == 0 && read_count(&c, &rows, "") == 0 &&
           read_numbers(&c, v, 3, "") == 0;
}

static int64_t ptx_block_len(const uint8_t *bytes, size_t len, struct dx_err *err)
{
    struct dx_text_cursor c = dx_text_cursor_init(bytes, len, err);
    struct ptx_header h;
    int rc;

    dx_text_skip_blank_lines(&c);
    if (c.p == c.end)
        return 0;
    rc = read_header(&c, &h);
    if (rc)
        return rc;
    for (uint64_t n = (uint64_t)h.cols * h.rows; n > 0; n--) {
        if (c.p == c.end)
            return dx_text_error(&c, c.p, "a point");
        dx_text_skip_line(&c);
    }
    return c.p - (const char *)bytes;
}

static int ptx_decode(struct dx_xyz_frame *out, const uint8_t *bytes, size_t len,
                      struct dx_err *err)
{
    struct dx_text_cursor c = dx_text_cursor_init(bytes, len, err);
    struct ptx_header h;
    int rc = read_header(&c, &h);

    if (rc)
        return rc;
    rc = dx_xyz_frame_reserve(out, h.rows, h.cols);
    if (rc)
        return dx_err_set(err, rc, "no memory for %u x %u points", h.cols, h.rows);
    set_pose(out->pose, h.matrix);
    return read_points(&c, &h, out);
}

const struct dx_format dx_format_ptx = {"PTX", ".ptx", ptx_probe, ptx_block_len, ptx_decode};
