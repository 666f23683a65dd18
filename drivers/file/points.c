/* Which format a file of points has, and the list itself. */
#include "drivers/file/points_priv.h"

#include "drivers/file/format.h"
#include "drivers/file/slurp.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static const struct dx_points_format *const formats[] = {
    &dx_points_ply, &dx_points_pcd, &dx_points_stl, &dx_points_obj, &dx_points_ptx,
};

#define N_FORMATS (sizeof(formats) / sizeof(formats[0]))

int dx_point_list_reserve(struct dx_point_list *list, uint64_t more, struct dx_err *err)
{
    size_t cap = list->cap ? list->cap : 1024;
    double *xyz;

    if (more > DX_POINT_LIST_MAX - list->n)
        return dx_err_set(err, -EFBIG, "%llu points, expected at most %zu",
                          (unsigned long long)list->n + more, DX_POINT_LIST_MAX);
    if (list->n + more <= list->cap)
        return 0;
    while (cap < list->n + more)
        cap *= 2;
    xyz = realloc(list->xyz, 3 * cap * sizeof(*xyz));
    if (!xyz)
        return dx_err_set(err, -ENOMEM, "no memory for %zu points", cap);
    list->xyz = xyz;
    list->cap = cap;
    return 0;
}

int dx_point_list_add(struct dx_point_list *list, const double p[3], struct dx_err *err)
{
    int rc = list->n < list->cap ? 0 : dx_point_list_reserve(list, 1, err);

    if (rc < 0)
        return rc;
    memcpy(list->xyz + 3 * list->n++, p, 3 * sizeof(*p));
    return 0;
}

void dx_point_list_fini(struct dx_point_list *list)
{
    free(list->xyz);
    *list = (struct dx_point_list){0};
}

static const struct dx_points_format *find(const uint8_t *bytes, size_t len, const char *name)
{
    for (size_t k = 0; k < N_FORMATS; k++)
        if (formats[k]->probe && formats[k]->probe(bytes, len))
            return formats[k];
    for (size_t k = 0; name && k < N_FORMATS; k++)
        if (formats[k]->ext && dx_format_has_ext(name, formats[k]->ext))
            return formats[k];
    return &dx_points_lines;
}

int dx_point_list_parse(struct dx_point_list *list, const uint8_t *bytes, size_t len,
                        const char *name, struct dx_err *err)
{
    int rc;

    list->n = 0;
    if (len >= 8 && memcmp(bytes, "ASTM-E57", 8) == 0)
        return dx_err_set(err, -EBADMSG, "E57 is not read, expected PLY, PCD, PTX or text");
    rc = find(bytes, len, name)->parse(list, bytes, len, err);
    if (rc < 0)
        list->n = 0;
    return rc;
}

int dx_point_list_read(struct dx_point_list *list, const char *path, struct dx_err *err)
{
    struct dx_slurp s = {0};
    int rc = dx_slurp_file(&s, path, DX_SLURP_MAX, err);

    list->n = 0;
    if (rc == 0) {
        rc = dx_point_list_parse(list, s.bytes, s.len, path, err);
        if (rc < 0)
            dx_err_prefix(err, path);
    }
    dx_slurp_fini(&s);
    return rc;
}
