/*
 * Triangle meshes of files, not trusted: PLY as text or binary of either byte order, OBJ, STL as
 * text or binary; each may be gzip. Faces of more corners become fans; the corners of STL that have
 * the same coordinates become one point. One owner.
 */
#ifndef DX_TRIANGLE_LIST_H
#define DX_TRIANGLE_LIST_H

#include "drivers/file/points.h"

#define DX_TRIANGLE_LIST_MAX ((size_t)1 << 30)

struct dx_triangle_list {
    size_t n, cap;
    uint32_t *index; /* [n][3], into the points */
};

/* Replaces both lists by the mesh of a file. Corners are points that there are, and finite; two
 * corners of a triangle may be the same. Errors: as dx_point_list_read, -EBADMSG for what is no
 * mesh; then both are empty. */
int dx_triangle_list_read(struct dx_triangle_list *list, struct dx_point_list *points,
                          const char *path, struct dx_err *err);

/* The same for bytes in memory; the name may be NULL. */
int dx_triangle_list_parse(struct dx_triangle_list *list, struct dx_point_list *points,
                           const uint8_t *bytes, size_t len, const char *name, struct dx_err *err);
void dx_triangle_list_fini(struct dx_triangle_list *list);

#endif
