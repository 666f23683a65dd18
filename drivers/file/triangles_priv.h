/* The formats of triangles.h: each appends to a list. */
#ifndef DX_TRIANGLES_PRIV_H
#define DX_TRIANGLES_PRIV_H

#include "drivers/file/points_priv.h"
#include "drivers/file/triangles.h"

/* A face whose corners come one by one: zeroed at its start. */
struct dx_face {
    uint64_t n;
    uint32_t first, last;
};

/* Errors: -EBADMSG (no number of a point), -EFBIG, -ENOMEM. */
int dx_face_add(struct dx_face *f, struct dx_triangle_list *list, double corner,
                struct dx_err *err);

/* Vertices and faces. In points_ply.c, triangles_obj.c, triangles_stl.c. */
int dx_triangles_ply_parse(struct dx_triangle_list *list, struct dx_point_list *points,
                           const uint8_t *bytes, size_t len, struct dx_err *err);
int dx_triangles_obj_parse(struct dx_triangle_list *list, struct dx_point_list *points,
                           const uint8_t *bytes, size_t len, struct dx_err *err);
int dx_triangles_stl_parse(struct dx_triangle_list *list, struct dx_point_list *points,
                           const uint8_t *bytes, size_t len, struct dx_err *err);

#endif
