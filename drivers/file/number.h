/*
 * Decimal numbers in text, independent of the locale. Pure functions.
 */
#ifndef DX_NUMBER_H
#define DX_NUMBER_H

#include <stdbool.h>
#include <stdint.h>

/*
 * Reads [+-]digits[.digits][e[+-]digits], nan or inf(inity) in any case, from `p` and never from
 * `end` on. Returns where it stopped; NULL when there is no number. Rounded to nearest even,
 * exactly, for at most 19 significant digits with a value of 1e-27 to 1e27 times an integer below
 * 2^64; beyond, within a few units in the last place; overflow gives infinity.
 */
const char *dx_number_parse(const char *p, const char *end, double *out);

/* Decimal digits alone, value below 2^64. NULL when there are none or too many. */
const char *dx_number_parse_u64(const char *p, const char *end, uint64_t *out);

static inline bool dx_number_is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

/* Past blanks (space, tab, CR), not past the end of the line. */
static inline const char *dx_number_skip_blank(const char *p, const char *end)
{
    while (p < end && dx_number_is_blank(*p))
        p++;
    return p;
}

#endif
