/*
 * Bridging drop-outs: edges over one or two missing dexels between samples that would be joined if
 * they were neighbours, and the triangles beside them (strut.h). No sample is invented. A missing
 * dexel is spanned one way at the most, so struts never cross.
 */
#ifndef DX_STRUTS_H
#define DX_STRUTS_H

#include "core/grid/area.h"

/* Which way each missing dexel of the area is spanned: scratch. */
struct dx_spans {
    dx_bits lone[DX_AREA];               /* missing dexels among four that are there */
    dx_bits spanned[DX_AREA];            /* others that are spanned, */
    uint8_t at[DX_AREA][DX_AREA_STRIDE]; /* and how: struts.c */
};

/* Writes the strut codes of a tile (block order, zeros) from the area; whether there is any. */
bool dx_struts_code(uint8_t strut[DX_BLOCK_DEXELS], struct dx_spans *spans, const struct dx_area *a,
                    const struct dx_gates *gates, const struct dx_geometry *g,
                    const struct dx_tiling *tiling);

#endif
