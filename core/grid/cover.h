/*
 * The even array of a chosen size that covers the field of view of a scan: what its samples are
 * thinned into (represent.h). Pinhole for a pinhole, spinning for all others.
 */
#ifndef DX_COVER_H
#define DX_COVER_H

#include "core/base/err.h"
#include "core/grid/geometry.h"

/*
 * The outermost directions of `g` are the outermost of the result, which counts rows and columns
 * the same way round; at the size of an even `g` it is `g` again. Where `g` goes around or a turn
 * is full, so does the result, and its seam is closed as that of `g` is. Unit, range width and pose
 * are those of `g`. Errors: -EINVAL (sides below 2 or out of bounds, no extent; text in err),
 * -ENOMEM.
 */
int dx_cover_geometry(struct dx_geometry **out, const struct dx_geometry *g, uint32_t height,
                      uint32_t width, struct dx_err *err);

#endif
