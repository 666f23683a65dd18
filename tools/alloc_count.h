/*
 * How often this process has asked for memory: the linker sends the program's own calls of malloc
 * and its kin through the counters here (-Wl,--wrap, in the Makefile). Any thread.
 */
#ifndef DX_ALLOC_COUNT_H
#define DX_ALLOC_COUNT_H

#include <stdint.h>

uint64_t dx_alloc_count(void);

#endif
