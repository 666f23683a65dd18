/* OBJ: "f a/.. b/.. c/.." after the vertices, from 1, or backwards from the latest by -1. */
#include "drivers/file/triangles_priv.h"

#include "drivers/file/text_cursor.h"

#include <errno.h>

static bool is_line_of(const struct dx_text_cursor *c, char word)
{
    return c->p < c->end && *c->p == word && dx_text_ends_word(c, c->p + 1);
}

/* Of n vertices, of which n_so_far are before this line. */
static int take_corner(struct dx_text_cursor *c, size_t n_so_far, size_t n_all, double *corner)
{
    const bool back = *c->p == '-';
    const char *q;
    uint64_t n;

    q = dx_number_parse_u64(c->p + back, c->end, &n);
    if (!q || n == 0 || n > (back ? n_so_far : n_all) || (!dx_text_ends_word(c, q) && *q != '/'))
        return dx_text_error(c, c->p, "a vertex's number, of those that there are");
    *corner = (double)(back ? n_so_far - n : n - 1);
    while (!dx_text_ends_word(c, q))
        q++;
    c->p = q;
    return 0;
}

static int take_face(struct dx_triangle_list *list, struct dx_text_cursor *c, size_t n_so_far,
                     size_t n_all)
{
    struct dx_face f = {0};
    double corner = 0;
    int rc = 0;

    c->p++;
    while (rc == 0 && dx_text_next_word(c)) {
        rc = take_corner(c, n_so_far, n_all, &corner);
        if (rc == 0)
            rc = dx_face_add(&f, list, corner, c->err);
    }
    return rc == 0 && f.n < 3 ? dx_text_error(c, c->p, "three corners or more") : rc;
}

int dx_triangles_obj_parse(struct dx_triangle_list *list, struct dx_point_list *points,
                           const uint8_t *bytes, size_t len, struct dx_err *err)
{
    struct dx_text_cursor c = dx_text_cursor_init(bytes, len, err);
    size_t n_so_far = 0;
    int rc = dx_points_obj.parse(points, bytes, len, err);

    while (rc == 0 && c.p < c.end) {
        dx_text_next_word(&c);
        n_so_far += is_line_of(&c, 'v');
        if (is_line_of(&c, 'f'))
            rc = take_face(list, &c, n_so_far, points->n);
        if (rc == 0)
            dx_text_skip_line(&c);
    }
    return rc;
}
