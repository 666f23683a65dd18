/* The formats of points.h: each appends to a list. */
#ifndef DX_POINTS_PRIV_H
#define DX_POINTS_PRIV_H

#include "drivers/file/points.h"

#include <stdbool.h>

struct dx_points_format {
    const char *ext; /* ".ply"; NULL: told by content alone */
    /* What the bytes begin with looks like it. NULL: told by name alone. */
    bool (*probe)(const uint8_t *bytes, size_t len);
    int (*parse)(struct dx_point_list *list, const uint8_t *bytes, size_t len, struct dx_err *err);
};

extern const struct dx_points_format dx_points_ply, dx_points_stl, dx_points_pcd, dx_points_ptx,
    dx_points_obj, dx_points_lines;

#endif
