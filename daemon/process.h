/* What this process uses of the machine, for the status. Any thread. */
#ifndef DX_PROCESS_H
#define DX_PROCESS_H

#include <stdint.h>

struct dx_process {
    uint64_t rss_bytes; /* resident memory */
    double cpu_s;       /* of all threads since its start */
    uint32_t n_fds;     /* open descriptors */
    uint32_t max_fds;   /* it may have so many */
};

/* 0 is what the kernel does not say. */
void dx_process_look(struct dx_process *p);

#endif
