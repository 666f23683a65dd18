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
    uint8_t at[DX_AREA][DX_AREA_STRIDE]; /* struts.c: ways to be spanned */
    struct dx_row_missing missing[DX_AREA];
};

/* Fills the strut codes of a tile (block order) from the area. */
void dx_struts_code(uint8_t strut[DX_BLOCK_DEXELS], struct dx_spans *spans, const struct dx_area *a,
                    const struct dx_gates *gates, const struct dx_geometry *g,
                    const struct dx_tiling *tiling);

#endif
