/*
 * The log: one line a message to standard error, or to the journal where standard error is that,
 * with fields that say whom the line is about. Each call site may say ten lines a second; what it
 * swallowed it says later. Any thread; never blocks: a line that there is no room for is dropped.
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

/*
 * Whom the lines of a thread are about: STREAM=, DEVICE=, CLIENT_PID= and CLIENT_UID= in the
 * journal. A thread of a stream says so once, at its start; the loop for each line, and takes it
 * back. So what is called from there, down to a driver, need not know the stream.
 */
struct dx_log_about {
    const char *stream, *device; /* borrowed; NULL: none */
    int client_pid;              /* 0: none */
    unsigned client_uid;
};

/* The calling thread's, from now on. Returns what it was. */
struct dx_log_about dx_log_about(struct dx_log_about about);
/* The same for the device alone. */
void dx_log_about_device(const char *device);

/* Lines go to the journal that reads this socket; NULL: to standard error. Until it is called
 * JOURNAL_STREAM decides. Before other threads; `path` is borrowed. */
void dx_log_to_journal(const char *path);

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
