/*
 * A system that is short of descriptors or threads for one call: the program's own calls of
 * open(2), socket(2) and their kin, and of pthread_create(3), go through the wrappers of
 * fail_system.c
 * (-Wl,--wrap, in the Makefile). Calls are numbered over all threads.
 */
#ifndef FAIL_SYSTEM_H
#define FAIL_SYSTEM_H

#include <stdbool.h>
#include <stdint.h>

/* Call number `n` from here on, from 1, fails; 0: none does. */
void fail_system_arm(uint64_t n);

/* It has come to that. */
bool fail_system_has_failed(void);

/* The errno of it. */
int fail_system_why(void);

#endif
