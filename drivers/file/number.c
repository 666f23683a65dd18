/*
 * Decimal to binary. The digits are gathered in 64 bits; a small mantissa and power of ten need one
 * exact double operation (Clinger 1990, fast path), others one division or product of 128-bit
 * integers.
 */
#include "drivers/file/number.h"

#include <math.h>
#include <stddef.h>

#define MAX_DIGITS      19 /* that always fit in 64 bits */
#define MAX_EXACT_POWER 27 /* 5^27 < 2^63 */

static const double powers_of_ten[23] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                         1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                         1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* The case-insensitive word at p, or NULL. */
static const char *match(const char *p, const char *end, const char *word)
{
    for (; *word; p++, word++)
        if (p == end || (*p | 0x20) != *word)
            return NULL;
    return p;
}

static const char *parse_word(const char *p, const char *end, double *out)
{
    const char *q = match(p, end, "infinity");

    *out = INFINITY;
    if (q || (q = match(p, end, "inf")))
        return q;
    *out = NAN;
    return match(p, end, "nan");
}

static uint64_t power_of_five(int e)
{
    uint64_t v = 1;

    while (e-- > 0)
        v *= 5;
    return v;
}

/* v * 2^e, rounded to nearest even; `sticky`: v is truncated. Results are normal numbers. */
static double round_to_double(unsigned __int128 v, int e, bool sticky)
{
    uint64_t high = (uint64_t)(v >> 64), low = (uint64_t)v;
    int bits = high ? 128 - __builtin_clzll(high) : 64 - __builtin_clzll(low);
    int shift = bits - 53;
    uint64_t m;

    if (shift <= 0)
        return ldexp((double)low, e); /* exact */
    m = (uint64_t)(v >> shift);
    if ((v >> (shift - 1)) & 1) {
        bool rest = sticky || (v & (((unsigned __int128)1 << (shift - 1)) - 1)) != 0;

        m += rest || (m & 1);
    }
    return ldexp((double)m, e + shift);
}

/* m * 10^e, correctly rounded for |e| <= MAX_EXACT_POWER. */
static double scale_exact(uint64_t m, int e)
{
    unsigned __int128 v;
    uint64_t five = power_of_five(e < 0 ? -e : e);
    int shift;

    if (e >= 0)
        return round_to_double((unsigned __int128)m * five, e, false);
    shift = __builtin_clzll(m);
    v = (unsigned __int128)(m << shift) << 64;
    return round_to_double(v / five, e - 64 - shift, v % five != 0);
}

static double scale_far(uint64_t m, int64_t e)
{
    double v = (double)m;

    if (e > 400)
        return INFINITY;
    if (e < -400)
        return 0;
    for (; e >= 22; e -= 22)
        v *= 1e22;
    for (; e <= -22; e += 22)
        v /= 1e22;
    return e >= 0 ? v * powers_of_ten[e] : v / powers_of_ten[-e];
}

static double scale(uint64_t m, int64_t e)
{
    if (m == 0)
        return 0;
    if (m <= (uint64_t)1 << 53 && e >= -22 && e <= 22)
        return e < 0 ? (double)m / powers_of_ten[-e] : (double)m * powers_of_ten[e];
    if (e >= -MAX_EXACT_POWER && e <= MAX_EXACT_POWER)
        return scale_exact(m, (int)e);
    return scale_far(m, e);
}

/* The exponent after 'e'; without digits the number ends before the 'e'. */
static const char *parse_exponent(const char *p, const char *end, int64_t *exponent)
{
    const char *q = p + 1;
    bool negative = false;
    int64_t e = 0;

    if (q < end && (*q == '+' || *q == '-'))
        negative = *q++ == '-';
    if (q == end || !is_digit(*q))
        return p;
    for (; q < end && is_digit(*q); q++)
        if (e < 1000000)
            e = 10 * e + (*q - '0');
    *exponent += negative ? -e : e;
    return q;
}

/* Digits of one part of the mantissa. Those beyond MAX_DIGITS count in the exponent alone. */
struct mantissa {
    uint64_t value;
    int64_t exponent;
    int n_digits; /* significant ones */
};

static const char *parse_digits(const char *p, const char *end, struct mantissa *m, int fraction)
{
    for (; p < end && is_digit(*p); p++) {
        if (m->n_digits < MAX_DIGITS) {
            m->value = 10 * m->value + (uint64_t)(*p - '0');
            m->n_digits += m->value != 0;
            m->exponent -= fraction;
        } else {
            m->exponent += 1 - fraction;
        }
    }
    return p;
}

const char *dx_number_parse(const char *p, const char *end, double *out)
{
    struct mantissa m = {0};
    bool negative = false;
    const char *digits, *q;
    double v;

    if (p < end && (*p == '-' || *p == '+'))
        negative = *p++ == '-';
    digits = p;
    p = parse_digits(p, end, &m, 0);
    q = p;
    if (p < end && *p == '.')
        p = parse_digits(q + 1, end, &m, 1);
    if (p == digits || (q == digits && p == q + 1)) {
        p = parse_word(digits, end, &v);
        *out = negative ? -v : v;
        return p;
    }
    if (p < end && (*p | 0x20) == 'e')
        p = parse_exponent(p, end, &m.exponent);
    v = scale(m.value, m.exponent);
    *out = negative ? -v : v;
    return p;
}

const char *dx_number_parse_u64(const char *p, const char *end, uint64_t *out)
{
    const char *start = p;
    uint64_t v = 0;

    for (; p < end && is_digit(*p); p++) {
        uint64_t digit = (uint64_t)(*p - '0');

        if (v > (UINT64_MAX - digit) / 10)
            return NULL;
        v = 10 * v + digit;
    }
    *out = v;
    return p == start ? NULL : p;
}
