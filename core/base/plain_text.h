/*
 * Texts of others (clients, files, devices) that people read in a terminal: a line stays a line,
 * and nothing in it is a command to the terminal.
 */
#ifndef DX_PLAIN_TEXT_H
#define DX_PLAIN_TEXT_H

#include <stddef.h>

/* Blanks in place of control characters; the second half of them (U+0080 to U+009F) takes two
 * bytes. */
static inline void dx_plain_text(char *text, size_t len)
{
    unsigned char *p = (unsigned char *)text;

    for (size_t k = 0; k < len; k++) {
        if (p[k] < 0x20 || p[k] == 0x7f)
            p[k] = ' ';
        if (k > 0 && p[k - 1] == 0xc2 && p[k] >= 0x80 && p[k] < 0xa0)
            p[k - 1] = p[k] = ' ';
    }
}

#endif
