/* Words and lines of text from outside. */
#include "drivers/file/text_cursor.h"

#include <errno.h>
#include <string.h>

#define MAX_SHOWN 24

/* How much of what stands at p is shown: up to the next blank. */
static int shown_len(const struct dx_text_cursor *c, const char *p)
{
    const char *q = p;

    while (q < c->end && q - p<MAX_SHOWN && * q> ' ' && *q < 127)
        q++;
    return (int)(q - p);
}

int dx_text_error(const struct dx_text_cursor *c, const char *p, const char *expected)
{
    unsigned long long line = c->line;

    if (p >= c->end)
        return dx_err_set(c->err, -EBADMSG, "line %llu: the file ends, expected %s", line,
                          expected);
    if (*p == '\n')
        return dx_err_set(c->err, -EBADMSG, "line %llu: the line ends, expected %s", line,
                          expected);
    if (shown_len(c, p) == 0)
        return dx_err_set(c->err, -EBADMSG, "line %llu: byte 0x%02x, expected %s", line,
                          (unsigned char)*p, expected);
    return dx_err_set(c->err, -EBADMSG, "line %llu: \"%.*s\", expected %s", line, shown_len(c, p),
                      p, expected);
}

const char *dx_text_next_word(struct dx_text_cursor *c)
{
    c->p = dx_number_skip_blank(c->p, c->end);
    return c->p < c->end && *c->p != '\n' ? c->p : NULL;
}

bool dx_text_takes(struct dx_text_cursor *c, const char *word)
{
    const size_t len = strlen(word);

    if ((size_t)(c->end - c->p) < len || memcmp(c->p, word, len) != 0 ||
        !dx_text_ends_word(c, c->p + len))
        return false;
    c->p += len;
    return true;
}

int dx_text_end_line(struct dx_text_cursor *c)
{
    if (dx_text_next_word(c))
        return dx_text_error(c, c->p, "the end of the line");
    c->p += c->p < c->end;
    c->line++;
    return 0;
}

void dx_text_skip_line(struct dx_text_cursor *c)
{
    const char *q = memchr(c->p, '\n', (size_t)(c->end - c->p));

    c->p = q ? q + 1 : c->end;
    c->line++;
}

void dx_text_skip_blank_lines(struct dx_text_cursor *c)
{
    while (!dx_text_next_word(c) && c->p < c->end)
        dx_text_end_line(c);
}

int dx_text_number(struct dx_text_cursor *c, double *out, const char *what)
{
    const char *p = dx_number_skip_blank(c->p, c->end);
    const char *q = dx_number_parse(p, c->end, out);

    if (!q || !dx_text_ends_word(c, q))
        return dx_text_error(c, p, what);
    c->p = q;
    return 0;
}

int dx_text_count(struct dx_text_cursor *c, uint32_t *out, uint32_t max, const char *what)
{
    const char *p = dx_number_skip_blank(c->p, c->end);
    uint64_t v;
    const char *q = dx_number_parse_u64(p, c->end, &v);

    if (!q || !dx_text_ends_word(c, q) || v == 0 || v > max)
        return dx_text_error(c, p, what);
    *out = (uint32_t)v;
    c->p = q;
    return 0;
}
