/*
 * A place in text, for formats made of lines of words: knows its line, and says what it found where
 * something else was expected. Never reads at `end`.
 */
#ifndef DX_TEXT_CURSOR_H
#define DX_TEXT_CURSOR_H

#include "core/base/err.h"
#include "drivers/file/number.h"

#include <stddef.h>

struct dx_text_cursor {
    const char *p, *end;
    uint64_t line; /* of p, from 1 */
    struct dx_err *err;
};

static inline struct dx_text_cursor dx_text_cursor_init(const uint8_t *bytes, size_t len,
                                                        struct dx_err *err)
{
    const char *p = (const char *)bytes;

    return (struct dx_text_cursor){p, p + len, 1, err};
}

/* "line N: FOUND, expected EXPECTED"; FOUND is the word at `p`, or that line or file end. -EBADMSG.
 */
int dx_text_error(const struct dx_text_cursor *c, const char *p, const char *expected);

/* A word may end at p. */
static inline bool dx_text_ends_word(const struct dx_text_cursor *c, const char *p)
{
    return p == c->end || *p == '\n' || dx_number_is_blank(*p);
}

/* To the next word of the line; its start, or NULL at the line's end. */
const char *dx_text_next_word(struct dx_text_cursor *c);

/* Past this word, when it stands at p. */
bool dx_text_takes(struct dx_text_cursor *c, const char *word);

/* Past the end of line; an error when more than blanks is before it. */
int dx_text_end_line(struct dx_text_cursor *c);

void dx_text_skip_line(struct dx_text_cursor *c);
void dx_text_skip_blank_lines(struct dx_text_cursor *c);

/* The next word as a number (`what` for the error). */
int dx_text_number(struct dx_text_cursor *c, double *out, const char *what);
/* As an integer of 1 to `max`. */
int dx_text_count(struct dx_text_cursor *c, uint32_t *out, uint32_t max, const char *what);

#endif
