/*
 * Testbeds of umockdev in memory, where there is a folder for that: umockdev syncs each of the many
 * small files that a testbed is made of, and a disk that others write to makes each a long wait.
 */
#ifndef UMOCK_MEMORY_H
#define UMOCK_MEMORY_H

#include <stdlib.h>
#include <unistd.h>

/* Before main(): GLib looks once. */
__attribute__((constructor)) static void umock_in_memory(void)
{
    if (access("/dev/shm", W_OK | X_OK) == 0)
        setenv("TMPDIR", "/dev/shm", 0);
}

#endif
