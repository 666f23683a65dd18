/*
 * The log: one line a message to standard error, with the journal's priority prefix when that is
 * where it goes. Each call site may say ten lines a second; what it swallowed it says later. Any
 * thread; never blocks: a line that standard error has no room for is dropped.
 */
#ifndef DX_LOG_H
#define DX_LOG_H

#include <stdatomic.h>
#include <stdint.h>
#include <syslog.h>

/* State of a call site; the mutual exclusion is a compare-and-swap on the second. */
struct dx_log_site {
    _Atomic uint64_t second;
    _Atomic uint32_t n, n_swallowed;
};

/* Lines above this syslog priority are not written; LOG_INFO at the start. */
void dx_log_set_level(int level);
int dx_log_level(void);

__attribute__((format(printf, 4, 5))) void dx_log_write(struct dx_log_site *site, int level,
                                                        const char *subsystem, const char *fmt,
                                                        ...);

#define dx_log_at(level, subsystem, ...)                                                           \
    do {                                                                                           \
        static struct dx_log_site dx_log_here;                                                     \
        dx_log_write(&dx_log_here, level, subsystem, __VA_ARGS__);                                 \
    } while (0)

#define dx_log_error(subsystem, ...)   dx_log_at(LOG_ERR, subsystem, __VA_ARGS__)
#define dx_log_warning(subsystem, ...) dx_log_at(LOG_WARNING, subsystem, __VA_ARGS__)
#define dx_log_notice(subsystem, ...)  dx_log_at(LOG_NOTICE, subsystem, __VA_ARGS__)
#define dx_log_info(subsystem, ...)    dx_log_at(LOG_INFO, subsystem, __VA_ARGS__)
#define dx_log_debug(subsystem, ...)   dx_log_at(LOG_DEBUG, subsystem, __VA_ARGS__)

#endif
