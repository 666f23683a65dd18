/*
 * Unit vectors in two bytes: a direction is projected on an octahedron, whose lower half is folded
 * out into the corners of a square, and the square's two coordinates are counted from -127 to 127.
 * After Meyer et al. 2010 and Cigolle et al. 2014. Every operation is in binary32 and written down
 * in docs/protocol.md, so that all clients get the same bits. Pure functions; any thread.
 */
#ifndef DX_OCTAHEDRAL_H
#define DX_OCTAHEDRAL_H

#include <stdint.h>

#define DX_OCTAHEDRAL_MAX 127 /* of either coordinate; -128 stands for nothing */

/* `n` of any length; a vector without a direction is taken for (0, 0, 1). */
void dx_octahedral_encode(int8_t out[2], const float n[3]);

/* A unit vector, from coordinates within -127..127. */
void dx_octahedral_decode(float n[3], const int8_t in[2]);

#endif
