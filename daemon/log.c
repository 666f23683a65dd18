/* The log. Any thread. */
#include "daemon/log.h"

#include <poll.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/plain_text.h"
#include "daemon/clock.h"
#include "daemon/journal.h"

#define PER_SECOND 10
#define LINE_LEN   1024 /* less than PIPE_BUF: one write, whole lines */

#define PREFIX     "dexeld: " /* on standard error; the journal has it as a field */

static _Atomic int max_level = LOG_INFO;
static _Thread_local struct dx_log_about now_about;
static const char *journal_path = DX_JOURNAL_SOCKET;
static _Atomic int is_journal; /* 0: not known yet, 1: no, 2: yes */

void dx_log_set_level(int level)
{
    atomic_store_explicit(&max_level, level, memory_order_relaxed);
}

int dx_log_level(void)
{
    return atomic_load_explicit(&max_level, memory_order_relaxed);
}

struct dx_log_about dx_log_about(struct dx_log_about about)
{
    struct dx_log_about was = now_about;

    now_about = about;
    return was;
}

void dx_log_about_device(const char *device)
{
    now_about.device = device;
}

void dx_log_to_journal(const char *path)
{
    journal_path = path;
    atomic_store_explicit(&is_journal, path ? 2 : 1, memory_order_relaxed);
}

/* JOURNAL_STREAM names the device and inode that standard error had when the service manager made
 * it. Whoever asks first finds the same. */
static bool goes_to_journal(void)
{
    const char *stream = getenv("JOURNAL_STREAM");
    int answer = atomic_load_explicit(&is_journal, memory_order_relaxed);
    unsigned long long dev, ino;
    struct stat st;

    if (answer)
        return answer == 2;
    answer = 1;
    if (stream && sscanf(stream, "%llu:%llu", &dev, &ino) == 2 && fstat(STDERR_FILENO, &st) == 0 &&
        st.st_dev == dev && st.st_ino == ino)
        answer = 2;
    atomic_store_explicit(&is_journal, answer, memory_order_relaxed);
    return answer == 2;
}

/* Whether the site may speak; `n_swallowed`: lines it kept back before. */
static bool may_speak(struct dx_log_site *site, uint32_t *n_swallowed)
{
    uint64_t now = dx_clock_ns() / 1000000000u + 1;
    uint64_t second = atomic_load_explicit(&site->second, memory_order_relaxed);

    *n_swallowed = 0;
    if (second != now &&
        atomic_compare_exchange_strong_explicit(&site->second, &second, now, memory_order_relaxed,
                                                memory_order_relaxed)) {
        atomic_store_explicit(&site->n, 0, memory_order_relaxed);
        *n_swallowed = atomic_exchange_explicit(&site->n_swallowed, 0, memory_order_relaxed);
    }
    if (atomic_fetch_add_explicit(&site->n, 1, memory_order_relaxed) < PER_SECOND)
        return true;
    atomic_fetch_add_explicit(&site->n_swallowed, 1, memory_order_relaxed);
    return false;
}

static void put_line(char *line, size_t len)
{
    struct pollfd p = {STDERR_FILENO, POLLOUT, 0};
    ssize_t r;

    line[len++] = '\n';
    if (poll(&p, 1, 0) != 1 || !(p.revents & POLLOUT))
        return;
    r = write(STDERR_FILENO, line, len);
    (void)r;
}

void dx_log_write(struct dx_log_site *site, int level, const char *subsystem, const char *fmt, ...)
{
    char line[LINE_LEN];
    uint32_t n_swallowed;
    size_t len, text_at = 0;
    bool to_journal = goes_to_journal();
    va_list ap;
    int n;

    if (level > atomic_load_explicit(&max_level, memory_order_relaxed) ||
        !may_speak(site, &n_swallowed))
        return;
    if (to_journal) /* which its standard error takes off again, where its socket does not answer */
        text_at = (size_t)snprintf(line, sizeof(line), "<%d>", level);
    text_at += (size_t)snprintf(line + text_at, sizeof(line) - text_at, PREFIX);
    len = text_at + (size_t)snprintf(line + text_at, sizeof(line) - text_at, "%.32s: ", subsystem);
    va_start(ap, fmt);
    n = vsnprintf(line + len, sizeof(line) - 64 - len, fmt, ap);
    va_end(ap);
    if (n > 0)
        len = strnlen(line, sizeof(line) - 64);
    if (n_swallowed)
        len +=
            (size_t)snprintf(line + len, sizeof(line) - len, " (%u more suppressed)", n_swallowed);
    dx_plain_text(line, len);
    if (!to_journal ||
        !dx_journal_send(journal_path,
                         &(struct dx_journal_line){level, subsystem, line + text_at, &now_about}))
        put_line(line, len);
}
