/*
 * Unorganized points of files: XYZ, PTS and other lines of numbers, PLY, PCD, OBJ and STL vertices,
 * the points of PTX scans; each may be gzip. Coordinates are double: surveys have six digits before
 * the point and three behind, which a float does not hold. One owner.
 */
#ifndef DX_POINT_LIST_H
#define DX_POINT_LIST_H

#include "core/base/err.h"

#include <stddef.h>
#include <stdint.h>

#define DX_POINT_LIST_MAX ((size_t)1 << 30)

struct dx_point_list {
    size_t n, cap;
    double *xyz; /* [n][3]; not finite where the file has no number */
};

/* Replaces the list by the points of a file. The format is told by content, then by name; what is
 * of no other is read as lines of numbers. Errors: as dx_slurp_file; -EBADMSG (with line or byte,
 * what was found, what was expected), -EFBIG, -ENOMEM; then the list is empty. */
int dx_point_list_read(struct dx_point_list *list, const char *path, struct dx_err *err);

/* The same for bytes in memory; the name may be NULL. */
int dx_point_list_parse(struct dx_point_list *list, const uint8_t *bytes, size_t len,
                        const char *name, struct dx_err *err);
/* Room for `more` points behind the others; a point there. Errors: -EFBIG, -ENOMEM. */
int dx_point_list_reserve(struct dx_point_list *list, uint64_t more, struct dx_err *err);
int dx_point_list_add(struct dx_point_list *list, const double p[3], struct dx_err *err);
void dx_point_list_fini(struct dx_point_list *list);

#endif
