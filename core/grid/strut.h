/*
 * Struts: edges over one or two missing dexels, and the triangles beside them (ALGORITHMS 1.5).
 * What a strut makes is said by one byte, its code, at the missing dexel that owns it: the only one
 * it spans, or the upper (left) one of two. Pure functions; any thread.
 *
 * Positions are told along and across the strut: dexel C that owns it is (0, 0), its ends are
 * A = (-1, 0) and B = (len, 0). A strut down has rows along and columns across, a strut across the
 * other way round. On each side the polygon A, side[0], (side[1],) B may be filled:
 *
 *   chain   the dexels beside the missing ones: (0, t) and, of length 2, (1, t); t = -1 or +1
 *   bridge  the ends of the next strut, which begins and ends at most one dexel further
 *
 * A quadrilateral is cut from A to side[1], or from B to side[0]. Of two neighbouring struts the
 * one that begins higher (further left) owns the bridge, else the left (upper) one.
 */
#ifndef DX_STRUT_H
#define DX_STRUT_H

#include <stdbool.h>
#include <stdint.h>

enum dx_strut_side {
    DX_STRUT_OPEN = 0,
    DX_STRUT_CHAIN = 1,   /* 2: cut from B */
    DX_STRUT_LOWER = 3,   /* to (0, t), (2, t); of length 2 only. 4: cut from B */
    DX_STRUT_EVEN = 5,    /* to (-1, 1), (len, 1).               6: cut from B */
    DX_STRUT_LONGER = 7,  /* to (-1, 1), (2, 1);  of length 1.   8: cut from B */
    DX_STRUT_SHORTER = 9, /* to (-1, 1), (1, 1);  of length 2.  10: cut from B */
};

#define DX_STRUT_FIRST_SIDES   5
#define DX_STRUT_SECOND_SIDES  11
#define DX_STRUT_CODES         (1 + 2 * 2 * DX_STRUT_FIRST_SIDES * DX_STRUT_SECOND_SIDES)
#define DX_STRUT_MAX_TRIANGLES 4

struct dx_strut {
    bool across;    /* along a row; else along a column */
    uint8_t len;    /* missing dexels spanned: 1 or 2 */
    uint8_t first;  /* side t = -1 (left of a strut down, above a strut across): 0..4 */
    uint8_t second; /* side t = +1: 0..10 */
};

#define DX_STRUT_CODE(across, len, first, second)                                                  \
    (1u + ((2u * (across) + (len)-1u) * DX_STRUT_FIRST_SIDES + (first)) * DX_STRUT_SECOND_SIDES +  \
     (second))

/* 1..220; 0 is no strut. */
uint8_t dx_strut_code(const struct dx_strut *s);

/* False: no strut has this code (0, above 220, or a side that its length cannot have). A strut with
 * both sides open makes nothing and has no code either. */
bool dx_strut_decode(struct dx_strut *s, uint8_t code);

/* Struts over one dexel with dexels on its sides: nearly all there are. */
struct dx_lone_strut {
    bool across, first, second; /* sides that are closed */
};

/* False: the strut is of another kind. */
static inline bool dx_strut_is_lone(struct dx_lone_strut *s, uint8_t code)
{
    const unsigned n_across =
        2 * DX_STRUT_FIRST_SIDES * DX_STRUT_SECOND_SIDES; /* their first code */
    const unsigned second = 1 + DX_STRUT_CHAIN, first = 1 + DX_STRUT_CHAIN * DX_STRUT_SECOND_SIDES;
    const bool across = code > n_across;
    const unsigned sides = across ? code - n_across : code;

    *s = (struct dx_lone_strut){across, sides >= first, sides != first};
    return sides == second || sides == first || sides == first + DX_STRUT_CHAIN;
}

/* A vertex relative to C. */
struct dx_strut_corner {
    int8_t row, col;
};

/* Triangles of a code, oriented as a cell's abc; how many (0 for what decode refuses). */
unsigned dx_strut_triangles(struct dx_strut_corner out[DX_STRUT_MAX_TRIANGLES][3], uint8_t code);

#endif
