/*
 * Configuration values as text: what a key allows, a value as a file would have it, and text from
 * outside made fit for a message. Numbers are written in the C locale whatever the process has.
 */
#include "daemon/config_table.h"

#include <locale.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

static const char *word_at(const struct dx_config_key *key, unsigned i)
{
    if (key->word)
        return key->word(i);
    return key->words ? key->words[i].text : NULL;
}

/* The word for a value of the field, or NULL. */
static const char *word_for(const struct dx_config_key *key, double value)
{
    const char *word;

    for (unsigned i = 0; (word = word_at(key, i)); i++)
        if (value == (key->word ? (int)i : key->words[i].value))
            return word;
    return NULL;
}

/* The fewest digits that read back as the same number; whole numbers without an exponent. */
static void number_text(char text[32], double v)
{
    locale_t c = newlocale(LC_ALL_MASK, "C", (locale_t)0), before = (locale_t)0;
    bool whole = v == floor(v) && fabs(v) < 1e16;

    if (c)
        before = uselocale(c);
    if (whole)
        snprintf(text, 32, "%.0f", v);
    for (int digits = 1; !whole && digits <= 17; digits++) {
        snprintf(text, 32, "%.*g", digits, v);
        if (strtod(text, NULL) == v)
            break;
    }
    if (c) {
        uselocale(before);
        freelocale(c);
    }
}

__attribute__((format(printf, 2, 3))) static void add(char text[DX_CONFIG_ALLOWED_LEN],
                                                      const char *fmt, ...)
{
    size_t len = strlen(text);
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(text + len, DX_CONFIG_ALLOWED_LEN - len, fmt, ap);
    va_end(ap);
}

/* "real, max or "; a choice ends without the "or". */
static void add_words(char text[DX_CONFIG_ALLOWED_LEN], const struct dx_config_key *key)
{
    bool choice = key->type == DX_CONFIG_CHOICE;

    for (unsigned i = 0; word_at(key, i); i++) {
        if (i)
            add(text, "%s", choice && !word_at(key, i + 1) ? " or " : ", ");
        add(text, "%s", word_at(key, i));
    }
    if (*text && !choice)
        add(text, "%s", key->type == DX_CONFIG_NUMBERS ? ", " : " or ");
}

static void add_range(char text[DX_CONFIG_ALLOWED_LEN], const struct dx_config_key *key)
{
    char min[32], max[32];

    number_text(min, key->min);
    number_text(max, key->max);
    add(text, " from %s to %s", min, max);
}

void dx_config_value_allowed_item(const struct dx_config_key *key, char text[DX_CONFIG_ALLOWED_LEN])
{
    *text = '\0';
    add(text, "a number");
    add_range(text, key);
}

static void add_numbers(char text[DX_CONFIG_ALLOWED_LEN], const struct dx_config_key *key)
{
    if (key->type == DX_CONFIG_NUMBERS)
        add(text,
            key->three ? "a number or a list of 3, each" : "a number or a list of up to 3, each");
    else
        add(text, key->type == DX_CONFIG_UINT ? "a whole number" : "a number");
    add_range(text, key);
}

void dx_config_value_allowed(const struct dx_config_key *key, char text[DX_CONFIG_ALLOWED_LEN])
{
    *text = '\0';
    add_words(text, key);
    switch (key->type) {
    case DX_CONFIG_MAP:
    case DX_CONFIG_DRIVER:
        add(text, "a map of keys");
        break;
    case DX_CONFIG_STREAMS:
        add(text, "a list of %.0f to %.0f streams", key->min, key->max);
        break;
    case DX_CONFIG_BOOL:
        add(text, "yes or no");
        break;
    case DX_CONFIG_CHOICE:
        break;
    case DX_CONFIG_SIZE:
        add(text, "COLUMNSxROWS, each from %.0f to %.0f, at most %u dexels", key->min, key->max,
            DX_PLANE_MAX_DEXELS);
        break;
    case DX_CONFIG_NAME:
        add(text, "%.0f to %.0f letters, digits and . _ -", key->min, key->max);
        break;
    case DX_CONFIG_PATH:
        add(text, "a path of %.0f to %.0f bytes", key->min, key->max);
        break;
    case DX_CONFIG_UINT:
    case DX_CONFIG_NUMBER:
    case DX_CONFIG_NUMBERS:
        add_numbers(text, key);
        break;
    }
}

/*
 * Bytes of the control character, line separator or noncharacter that is at `text`, 0 if it is none
 * of them: what a terminal would act on, or YAML not take as it is (YAML 1.1, 5.1 and 5.4).
 */
static size_t special(const char *text, unsigned *code)
{
    const unsigned char *p = (const unsigned char *)text;

    if (*p < 0x20 || *p == 0x7f) {
        *code = *p;
        return 1;
    }
    if (*p == 0xc2 && p[1] >= 0x80 && p[1] < 0xa0) {
        *code = p[1];
        return 2;
    }
    if ((*p & 0xf0) != 0xe0 || !p[1] || !p[2])
        return 0;
    *code = (*p & 0xfu) << 12 | (p[1] & 0x3fu) << 6 | (p[2] & 0x3fu);
    return *code == 0x2028 || *code == 0x2029 || *code == 0xfeff || *code >= 0xfffe ? 3 : 0;
}

void dx_config_quote(char out[DX_CONFIG_QUOTE_LEN], const char *text)
{
    size_t len = strlen(text), room = DX_CONFIG_QUOTE_LEN - sizeof("'...'");
    bool cut = len > room;
    const char *end;
    char *p = out;

    if (cut)
        len = room;
    while (cut && len && ((unsigned char)text[len] & 0xc0) == 0x80)
        len--; /* not in the middle of a UTF-8 character */
    end = text + len;
    *p++ = '\'';
    while (text < end) {
        unsigned code;
        size_t n = special(text, &code);

        *p++ = n ? '?' : *text;
        text += n ? n : 1;
    }
    strcpy(p, cut ? "...'" : "'");
}

static void print_number(FILE *out, double v)
{
    char text[32];

    number_text(text, v);
    fputs(text, out);
}

/* Double-quoted, so that no text is taken for a number or has to be folded. */
static void print_text(FILE *out, const char *text)
{
    unsigned code;

    putc('"', out);
    while (*text) {
        size_t n = special(text, &code);

        if (n) {
            fprintf(out, "\\u%04x", code);
            text += n;
            continue;
        }
        if (*text == '"' || *text == '\\')
            putc('\\', out);
        putc(*text++, out);
    }
    putc('"', out);
}

static void print_numbers(const struct dx_config_key *key, const void *base, FILE *out)
{
    const double *v = (const void *)((const char *)base + key->at);

    if (key->other && !*((const bool *)base + key->other)) {
        fputs(word_for(key, 0), out);
        return;
    }
    for (unsigned i = 0; i < 3; i++) {
        fputs(i ? ", " : "[", out);
        print_number(out, v[i]);
    }
    putc(']', out);
}

static void print_number_or_word(const struct dx_config_key *key, const void *at, FILE *out)
{
    const char *word;
    double v;

    memcpy(&v, at, sizeof(v));
    word = word_for(key, v);
    if (word)
        fputs(word, out);
    else
        print_number(out, v);
}

/* The value of a whole-number field or a choice, whatever its width. */
static int64_t integer(const struct dx_config_key *key, const void *at)
{
    uint64_t u64;
    uint32_t u32;
    int word;

    if (key->size == 1)
        return *(const uint8_t *)at;
    if (key->size == sizeof(u64)) {
        memcpy(&u64, at, sizeof(u64));
        return (int64_t)u64;
    }
    if (key->type == DX_CONFIG_UINT) {
        memcpy(&u32, at, sizeof(u32));
        return u32;
    }
    memcpy(&word, at, sizeof(word));
    return word;
}

/* A size of zero is what the word left to be found out. */
static void print_size(const struct dx_config_key *key, const void *base, FILE *out)
{
    uint32_t width, height;

    memcpy(&width, (const char *)base + key->at, sizeof(width));
    memcpy(&height, (const char *)base + key->other, sizeof(height));
    if (width == 0 && height == 0)
        fputs(word_for(key, 0), out);
    else
        fprintf(out, "%ux%u", width, height);
}

void dx_config_value_print(const struct dx_config_key *key, const void *base, FILE *out)
{
    const void *at = (const char *)base + key->at;

    switch (key->type) {
    case DX_CONFIG_BOOL:
        fputs(*(const bool *)at ? "yes" : "no", out);
        break;
    case DX_CONFIG_UINT:
        fprintf(out, "%lld", (long long)integer(key, at));
        break;
    case DX_CONFIG_NUMBER:
        print_number_or_word(key, at, out);
        break;
    case DX_CONFIG_NUMBERS:
        print_numbers(key, base, out);
        break;
    case DX_CONFIG_CHOICE:
        fputs(word_for(key, (double)integer(key, at)), out);
        break;
    case DX_CONFIG_SIZE:
        print_size(key, base, out);
        break;
    case DX_CONFIG_NAME:
    case DX_CONFIG_PATH:
        print_text(out, *(char *const *)at);
        break;
    case DX_CONFIG_MAP:
    case DX_CONFIG_DRIVER:
    case DX_CONFIG_STREAMS:
        break;
    }
}
