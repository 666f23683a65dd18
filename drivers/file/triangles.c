/* Which format a mesh file has, and the list itself. */
#include "drivers/file/triangles_priv.h"

#include "drivers/file/format.h"
#include "drivers/file/slurp.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

static const struct {
    const struct dx_points_format *points; /* tells it */
    int (*parse)(struct dx_triangle_list *list, struct dx_point_list *points, const uint8_t *bytes,
                 size_t len, struct dx_err *err);
} formats[] = {
    {&dx_points_ply, dx_triangles_ply_parse},
    {&dx_points_stl, dx_triangles_stl_parse},
    {&dx_points_obj, dx_triangles_obj_parse},
};

#define N_FORMATS (sizeof(formats) / sizeof(formats[0]))

static int add(struct dx_triangle_list *list, uint32_t a, uint32_t b, uint32_t c,
               struct dx_err *err)
{
    uint32_t *t;

    if (list->n == list->cap) {
        const size_t cap = list->cap ? 2 * list->cap : 1024;
        uint32_t *index;

        if (list->n == DX_TRIANGLE_LIST_MAX)
            return dx_err_set(err, -EFBIG, "more than %zu triangles", DX_TRIANGLE_LIST_MAX);
        index = realloc(list->index, 3 * cap * sizeof(*index));
        if (!index)
            return dx_err_set(err, -ENOMEM, "no memory for %zu triangles", cap);
        list->index = index;
        list->cap = cap;
    }
    t = list->index + 3 * list->n++;
    t[0] = a;
    t[1] = b;
    t[2] = c;
    return 0;
}

int dx_face_add(struct dx_face *f, struct dx_triangle_list *list, double corner, struct dx_err *err)
{
    int rc = 0;

    if (!(corner >= 0 && corner < DX_POINT_LIST_MAX) || corner != floor(corner))
        return dx_err_set(err, -EBADMSG, "face %zu: corner %g, expected a vertex's number", list->n,
                          corner);
    if (f->n == 0)
        f->first = (uint32_t)corner;
    else if (f->n > 1)
        rc = add(list, f->first, f->last, (uint32_t)corner, err);
    f->last = (uint32_t)corner;
    f->n++;
    return rc;
}

static int check(const struct dx_triangle_list *list, const struct dx_point_list *points,
                 struct dx_err *err)
{
    for (size_t k = 0; k < 3 * list->n; k++) {
        const uint32_t v = list->index[k];
        const double *p;

        if (v >= points->n)
            return dx_err_set(err, -EBADMSG, "triangle %zu: vertex %u, expected less than %zu",
                              k / 3, v, points->n);
        p = points->xyz + 3 * (size_t)v;
        if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]))
            return dx_err_set(err, -EBADMSG, "vertex %u: a coordinate that is not finite", v);
    }
    return 0;
}

int dx_triangle_list_parse(struct dx_triangle_list *list, struct dx_point_list *points,
                           const uint8_t *bytes, size_t len, const char *name, struct dx_err *err)
{
    size_t k = 0;
    int rc;

    list->n = points->n = 0;
    while (k < N_FORMATS && !(formats[k].points->probe && formats[k].points->probe(bytes, len)))
        k++;
    if (k == N_FORMATS)
        for (k = 0; k < N_FORMATS; k++)
            if (name && dx_format_has_ext(name, formats[k].points->ext))
                break;
    rc = k < N_FORMATS ? formats[k].parse(list, points, bytes, len, err)
                       : dx_err_set(err, -EBADMSG, "no mesh, expected PLY, OBJ or STL");
    if (rc == 0)
        rc = check(list, points, err);
    if (rc < 0)
        list->n = points->n = 0;
    return rc;
}

int dx_triangle_list_read(struct dx_triangle_list *list, struct dx_point_list *points,
                          const char *path, struct dx_err *err)
{
    struct dx_slurp s = {0};
    int rc = dx_slurp_file(&s, path, DX_SLURP_MAX, err);

    list->n = points->n = 0;
    if (rc == 0) {
        rc = dx_triangle_list_parse(list, points, s.bytes, s.len, path, err);
        if (rc < 0)
            dx_err_prefix(err, path);
    }
    dx_slurp_fini(&s);
    return rc;
}

void dx_triangle_list_fini(struct dx_triangle_list *list)
{
    free(list->index);
    *list = (struct dx_triangle_list){0};
}
