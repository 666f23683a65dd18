/*
 * The constants of terrain mode's rules, in integers, made once for a geometry and its parameters
 * (docs/terrain.md): a pair of neighbours with ranges x >= m passes a gate of constant c when
 * x - m <= t0 + (m * c >> 16) + ((m * m >> 16) * n2 >> 16). Immutable after set; read by all tile
 * tasks.
 *
 * Even grids have one constant a row, that of column 0. Uneven ones (per_dexel: a table of
 * directions, or columns with uneven steps) have one a dexel for what is asked often, and compute
 * the others when they are asked for.
 */
#ifndef DX_GATES_H
#define DX_GATES_H

#include "core/grid/sigma.h"
#include "core/grid/terrain.h"
#include "core/rows/rows.h"

/* Edges of cell (i,j): H from a to b, V from a to d, AC, BD. Also the four lines through a dexel.
 */
enum dx_edge { DX_EDGE_H, DX_EDGE_V, DX_EDGE_AC, DX_EDGE_BD, DX_N_EDGES };

/* Two directions and two lengths of struts: index DX_SPAN(across, length). */
#define DX_SPAN(across, len) (2 * (unsigned)(across) + (len)-1u)
#define DX_N_SPANS           4

/*
 * A plane in inverse range is linear in direction: q(x) = minus * q(x-) + plus * q(x+) for the
 * neighbours of x on a line. Weights * 2^24; both 0 where the line has no neighbours.
 */
struct dx_line {
    uint32_t minus, plus;
};

struct dx_gates {
    /* The rules in force: the parameters, or none of them in the paper's mode. */
    bool first_order, rescue;
    enum dx_mixed mixed;
    enum dx_diag diag;
    uint8_t bridge;
    uint32_t margin; /* dexels beyond a tile's own that its outcome depends on */

    bool wide; /* 64-bit arithmetic: 32-bit ranges, or a term that can exceed 65535 */
    uint32_t t0;
    uint64_t n2;
    uint64_t cap; /* longest edge, units * 2^12; 0 = no cap */
    struct dx_sigma sigma;
    const struct dx_rows *rows;    /* the instruction set */
    struct dx_row_sigma row_sigma; /* sigma, for its loops */
    double tilt_rad, noise_slope;  /* for constants computed when they are asked for */

    bool per_dexel;
    uint32_t *c[DX_N_EDGES];     /* of each edge: [i], or per_dexel [i * width + j]; 0: no edge */
    uint32_t *steep[DX_N_EDGES]; /* of the steepest plane that the rescue believes; even only */
    uint32_t *span[DX_N_SPANS];  /* of struts that begin at row i - 1 or column -1; even only */
    struct dx_line *line[DX_N_EDGES]; /* as c */
    uint8_t *faces;   /* bit n: struts of span n face the scanner (faces.h); even only: [i] */
    uint64_t *folded; /* bit per cell i * cell_cols + j whose directions fold; NULL when none can */
};

/* Allocates, and finds what depends on the directions alone. Errors: -ENOMEM. */
int dx_gates_init(struct dx_gates *gates, const struct dx_geometry *g);
void dx_gates_fini(struct dx_gates *gates);

/* Computes the constants; allocates nothing, so that it can follow the first frame's noise
 * estimate. */
void dx_gates_set(struct dx_gates *gates, const struct dx_geometry *g,
                  const struct dx_terrain_params *params);

/* The constants of one edge of cell (i,j), and of a strut whose first missing dexel is (i,j). */
uint32_t dx_gates_steep(const struct dx_gates *gates, const struct dx_geometry *g, enum dx_edge e,
                        uint32_t i, uint32_t j);
uint32_t dx_gates_span(const struct dx_gates *gates, const struct dx_geometry *g, bool across,
                       uint8_t len, uint32_t i, uint32_t j);

/* Whether such a strut's triangles face the scanner, whichever they are. */
bool dx_gates_faces(const struct dx_gates *gates, const struct dx_geometry *g, bool across,
                    uint8_t len, uint32_t i, uint32_t j);

static inline struct dx_line dx_gates_line(const struct dx_gates *gates, uint32_t width,
                                           enum dx_edge e, uint32_t i, uint32_t j)
{
    return gates->line[e][gates->per_dexel ? (size_t)i * width + j : i];
}

/* Whether x and y (neither 0) pass the gate of constant c. */
static inline bool dx_gates_pass(const struct dx_gates *gates, uint32_t x, uint32_t y, uint32_t c)
{
    uint64_t lo = x < y ? x : y, hi = x < y ? y : x;
    unsigned __int128 square;

    if (!gates->wide) /* each factor has 16 bits */
        return hi - lo <= gates->t0 + (lo * c >> 16) + ((lo * lo >> 16) * gates->n2 >> 16);
    square = (unsigned __int128)(lo * lo >> 16) * gates->n2 >> 16;
    return hi - lo <= gates->t0 + (lo * c >> 16) + square;
}

#endif
