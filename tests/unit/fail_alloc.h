/*
 * An allocator that fails one call: the program's own calls of malloc and its kin go through the
 * wrappers of fail_alloc.c (-Wl,--wrap, in the Makefile), jansson's too. Calls are numbered over
 * all threads.
 */
#ifndef FAIL_ALLOC_H
#define FAIL_ALLOC_H

#include <stdbool.h>
#include <stdint.h>

/* Call number `n` from here on, from 1, finds no memory; 0: all do. */
void fail_alloc_arm(uint64_t n);

/* It has come to that. */
bool fail_alloc_has_failed(void);

#endif
