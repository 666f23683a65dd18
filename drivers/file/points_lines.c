/*
 * Lines of numbers: x y z and whatever follows. PTS has the number of points in a line before them;
 * tables have a line of names. Blanks, commas or semicolons separate. "p x y z" and "Vertex i x y
 * z" are lines of files of range points, "v x y z" of OBJ; other lines of these two are left out.
 */
#include "drivers/file/points_priv.h"

#include "drivers/file/text_cursor.h"

#include <errno.h>

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '"';
}

static bool is_separator(char c)
{
    return dx_number_is_blank(c) || c == ',' || c == ';';
}

static void skip_separators(struct dx_text_cursor *c)
{
    while (c->p < c->end && is_separator(*c->p))
        c->p++;
}

/* The next number of the line; 1: the line has no more. */
static int take_number(struct dx_text_cursor *c, double *out)
{
    const char *q;

    skip_separators(c);
    if (c->p == c->end || *c->p == '\n')
        return 1;
    q = dx_number_parse(c->p, c->end, out);
    if (!q || (q < c->end && *q != '\n' && !is_separator(*q)))
        return dx_text_error(c, c->p, "a number");
    c->p = q;
    return 0;
}

/* `n` numbers from here; how many there were, or negative. */
static int take_numbers(struct dx_text_cursor *c, double *v, int n)
{
    for (int k = 0; k < n; k++) {
        const int rc = take_number(c, &v[k]);

        if (rc)
            return rc < 0 ? rc : k;
    }
    return n;
}

static int add_point(struct dx_point_list *list, struct dx_text_cursor *c)
{
    double p[3];
    const int n = take_numbers(c, p, 3);

    if (n < 0)
        return n;
    if (n < 3)
        return dx_text_error(c, c->p, "x y z");
    return dx_point_list_add(list, p, c->err);
}

/* A line that begins with a letter: a point by its keyword, or a line of names before any point. */
static int read_keyword(struct dx_point_list *list, struct dx_text_cursor *c, bool *is_range_file)
{
    double number;

    if (dx_text_takes(c, "p") || dx_text_takes(c, "v")) {
        *is_range_file = true;
        return add_point(list, c);
    }
    if (dx_text_takes(c, "Vertex")) {
        *is_range_file = true;
        return take_number(c, &number) ? dx_text_error(c, c->p, "a number and x y z")
                                       : add_point(list, c);
    }
    if (list->n == 0 || *is_range_file)
        return 0;
    return dx_text_error(c, c->p, "x y z");
}

/* The number of points that PTS tells before them. */
struct count {
    bool is_told;
    double n;
};

/* A line that begins with a number: a point, or the number of them. */
static int read_numbers(struct dx_point_list *list, struct dx_text_cursor *c, struct count *count)
{
    const char *const start = c->p;
    double v[3];
    const int n = take_numbers(c, v, 3);

    if (n < 0)
        return n;
    if (n == 1 && list->n == 0 && !count->is_told) {
        *count = (struct count){true, v[0]};
        return v[0] >= 0 && v[0] <= DX_POINT_LIST_MAX
                   ? 0
                   : dx_text_error(c, start, "x y z, or the number of points");
    }
    if (count->is_told && (double)list->n >= count->n)
        return dx_text_error(c, start, "no more points than the first line tells");
    if (n < 3)
        return dx_text_error(c, c->p, "x y z");
    return dx_point_list_add(list, v, c->err);
}

static bool is_nan(const struct dx_text_cursor *c)
{
    double v;
    const char *q = dx_number_parse(c->p, c->end, &v);

    return q && (q == c->end || *q == '\n' || is_separator(*q));
}

static int lines_parse(struct dx_point_list *list, const uint8_t *bytes, size_t len,
                       struct dx_err *err)
{
    struct dx_text_cursor c = dx_text_cursor_init(bytes, len, err);
    struct count count = {0};
    bool is_range_file = false;

    while (c.p < c.end) {
        int rc = 0;

        skip_separators(&c);
        if (c.p < c.end && is_letter(*c.p) && !is_nan(&c))
            rc = read_keyword(list, &c, &is_range_file);
        else if (c.p < c.end && *c.p != '\n' && *c.p != '#' && *c.p != '/')
            rc = read_numbers(list, &c, &count);
        if (rc < 0)
            return rc;
        dx_text_skip_line(&c);
    }
    if (count.is_told && (double)list->n < count.n)
        return dx_err_set(err, -EBADMSG, "line %llu: the file ends after %zu points, expected %.0f",
                          (unsigned long long)c.line, list->n, count.n);
    return 0;
}

/* Vertices alone: "v x y z". */
static int obj_parse(struct dx_point_list *list, const uint8_t *bytes, size_t len,
                     struct dx_err *err)
{
    struct dx_text_cursor c = dx_text_cursor_init(bytes, len, err);

    while (c.p < c.end) {
        skip_separators(&c);
        if (dx_text_takes(&c, "v")) {
            const int rc = add_point(list, &c);

            if (rc < 0)
                return rc;
        }
        dx_text_skip_line(&c);
    }
    return 0;
}

const struct dx_points_format dx_points_lines = {NULL, NULL, lines_parse};
const struct dx_points_format dx_points_obj = {".obj", NULL, obj_parse};
