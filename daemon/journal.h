/*
 * Lines to the journal by its native protocol (systemd's JOURNAL_NATIVE_PROTOCOL): one datagram
 * each, with fields of their own beside the text. libsystemd's sd_journal_sendv() is not used, for
 * it waits when the journal does not read. Any thread.
 */
#ifndef DX_JOURNAL_H
#define DX_JOURNAL_H

#include <stdbool.h>

#include "daemon/log.h"

#define DX_JOURNAL_SOCKET "/run/systemd/journal/socket"

struct dx_journal_line {
    int level;             /* PRIORITY= */
    const char *subsystem; /* SUBSYSTEM= */
    const char *text;      /* MESSAGE=; one line */
    const struct dx_log_about *about;
};

/* Never waits: a line that the journal has no room for is dropped, and counts as sent. False: there
 * is no journal at `path`. */
bool dx_journal_send(const char *path, const struct dx_journal_line *line);

#endif
