/* STL: three points a triangle; those of the same coordinates become one. */
#include "drivers/file/triangles_priv.h"

#include "core/base/hash.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define FREE UINT32_MAX

/* Where the point is in the table, or would be. */
static size_t slot_of(const uint32_t *table, size_t mask, const double *xyz, const double p[3])
{
    size_t k = dx_hash(0, p, 3 * sizeof(*p)) & mask;

    while (table[k] != FREE && memcmp(xyz + 3 * (size_t)table[k], p, 3 * sizeof(*p)) != 0)
        k = (k + 1) & mask;
    return k;
}

/* to[k] is the number of point k among the different ones, which move to the front. */
static int weld(uint32_t *to, struct dx_point_list *points)
{
    size_t size = 1024, n = 0;
    uint32_t *table;

    while (size < 2 * points->n)
        size *= 2;
    table = malloc(size * sizeof(*table));
    if (!table)
        return -ENOMEM;
    memset(table, 0xff, size * sizeof(*table));
    for (size_t k = 0; k < points->n; k++) {
        double p[3];
        size_t slot;

        for (size_t i = 0; i < 3; i++)
            p[i] = points->xyz[3 * k + i] + 0.0; /* -0 is 0 */
        slot = slot_of(table, size - 1, points->xyz, p);
        if (table[slot] == FREE) {
            memcpy(points->xyz + 3 * n, p, sizeof(p));
            table[slot] = (uint32_t)n++;
        }
        to[k] = table[slot];
    }
    points->n = n;
    free(table);
    return 0;
}

int dx_triangles_stl_parse(struct dx_triangle_list *list, struct dx_point_list *points,
                           const uint8_t *bytes, size_t len, struct dx_err *err)
{
    int rc = dx_points_stl.parse(points, bytes, len, err);
    const size_t n = points->n;
    uint32_t *to;

    if (rc < 0)
        return rc;
    if (n % 3 != 0)
        return dx_err_set(err, -EBADMSG, "%zu vertices, expected three a triangle", n);
    to = malloc(n * sizeof(*to) + 1);
    rc = to ? weld(to, points) : -ENOMEM;
    if (rc < 0)
        dx_err_set(err, rc, "no memory for %zu vertices", n);
    for (size_t k = 0; rc == 0 && k < n; k += 3) {
        struct dx_face f = {0};

        for (size_t i = 0; rc == 0 && i < 3; i++)
            rc = dx_face_add(&f, list, to[k + i], err);
    }
    free(to);
    return rc;
}
