/* How much memory a command can still take. Any thread. */
#ifndef DX_MEMORY_FREE_H
#define DX_MEMORY_FREE_H

#include <stdint.h>

/* Bytes that the machine has free, or can free, with its swap; less where a control group allows
 * less. UINT64_MAX where the system does not tell. */
uint64_t dx_memory_free(void);

/* The largest resident size of this process so far, bytes. */
uint64_t dx_memory_peak(void);

#endif
