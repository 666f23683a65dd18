/*
 * Bytes from a scanner, cut into replies: lines that end with LF, and an empty line behind the last
 * of them. The reply lies in the splitter's own buffer, with room before it for whoever makes a
 * block of it. Reader thread.
 */
#ifndef DX_SCIP_LINES_H
#define DX_SCIP_LINES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DX_SCIP_MAX_REPLY                                                                          \
    ((size_t)64 << 10) /* three echoes with intensities of 1081 steps: 24 kB */
#define DX_SCIP_MAX_ECHO 16

struct dx_scip_lines {
    uint8_t *room;  /* headroom bytes, then the reply */
    uint8_t *reply; /* [DX_SCIP_MAX_REPLY] */
    size_t len;
    size_t line;   /* where the line that is being received begins */
    bool done;     /* `reply` is whole: the next byte begins another */
    bool skipping; /* out of step: up to an empty line that `echo` follows */
    char echo[DX_SCIP_MAX_ECHO];
    size_t echo_len;
    uint64_t n_skipped; /* bytes that belong to no reply */
};

/* -ENOMEM. */
int dx_scip_lines_init(struct dx_scip_lines *l, size_t headroom);
void dx_scip_lines_fini(struct dx_scip_lines *l);
/* Drops what has come of a reply. */
void dx_scip_lines_clear(struct dx_scip_lines *l);

/* Takes bytes up to the end of a reply at most; returns how many. `l->done` tells whether a reply
 * lies ready; it stays until the next call. */
size_t dx_scip_lines_feed(struct dx_scip_lines *l, const uint8_t *bytes, size_t len);

/* What came was damaged: everything is skipped up to an empty line behind which a reply begins with
 * these `len` characters (DX_SCIP_MAX_ECHO at most). */
void dx_scip_lines_resync(struct dx_scip_lines *l, const char *echo, size_t len);

/* The lines of a reply in turn, without their LF. False behind the last one; the empty line at the
 * end is not given. */
struct dx_scip_cursor {
    const uint8_t *p, *end;
};

bool dx_scip_next_line(struct dx_scip_cursor *c, const uint8_t **line, size_t *len);

#endif
