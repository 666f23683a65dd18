/*
 * Values of configuration keys: from text to a field of the key's type, and back. Numbers are read
 * and written in the C locale whatever the process has.
 */
#include "daemon/config_table.h"

#include <ctype.h>
#include <errno.h>
#include <locale.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void *field(const struct dx_config_key *key, void *base)
{
    return (char *)base + key->at;
}

static const char *word_at(const struct dx_config_key *key, unsigned i, int *value)
{
    if (key->word) {
        *value = (int)i;
        return key->word(i);
    }
    if (!key->words)
        return NULL;
    *value = key->words[i].value;
    return key->words[i].text;
}

static bool find_word(const struct dx_config_key *key, const char *text, int *value)
{
    const char *word;

    for (unsigned i = 0; (word = word_at(key, i, value)); i++)
        if (!strcmp(word, text))
            return true;
    return false;
}

static const char *skip_digits(const char *p)
{
    while (*p >= '0' && *p <= '9')
        p++;
    return p;
}

/* [+-]digits[.digits][e[+-]digits], so that no hexadecimal, infinity or NaN gets to strtod. */
static bool is_decimal(const char *text)
{
    const char *p = text + (*text == '+' || *text == '-'), *whole = p;
    size_t n_digits;

    p = skip_digits(p);
    n_digits = (size_t)(p - whole);
    if (*p == '.') {
        const char *fraction = ++p;

        p = skip_digits(p);
        n_digits += (size_t)(p - fraction);
    }
    if (!n_digits)
        return false;
    if (*p == 'e' || *p == 'E') {
        const char *exponent;

        p++;
        p += *p == '+' || *p == '-';
        exponent = p;
        p = skip_digits(p);
        if (p == exponent)
            return false;
    }
    return !*p;
}

static int read_number(const struct dx_config_key *key, const char *text, double *out)
{
    locale_t c;
    double v;

    if (!is_decimal(text))
        return -EINVAL;
    c = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (!c)
        return -ENOMEM;
    v = strtod_l(text, NULL, c);
    freelocale(c);
    if (!isfinite(v) || v < key->min || v > key->max)
        return -EINVAL;
    *out = v == 0 ? 0 : v; /* no -0 */
    return 0;
}

/* Reads digits and moves past them; bounds are at most 2^53, which a double holds. */
static int read_whole(const struct dx_config_key *key, const char **text, uint64_t *out)
{
    const char *end = skip_digits(*text);

    if (end == *text)
        return -EINVAL;
    errno = 0;
    *out = strtoull(*text, NULL, 10);
    if (errno || *out > (uint64_t)key->max || *out < (uint64_t)key->min)
        return -EINVAL;
    *text = end;
    return 0;
}

static int set_uint(const struct dx_config_key *key, void *base, const char *text)
{
    uint64_t v;
    uint32_t v32;

    if (read_whole(key, &text, &v) || *text)
        return -EINVAL;
    v32 = (uint32_t)v;
    memcpy(field(key, base), key->size == sizeof(v) ? (void *)&v : (void *)&v32, key->size);
    return 0;
}

static int set_number(const struct dx_config_key *key, void *base, const char *text)
{
    double v;
    int word, r = 0;

    if (find_word(key, text, &word))
        v = word;
    else
        r = read_number(key, text, &v);
    if (!r)
        memcpy(field(key, base), &v, sizeof(v));
    return r;
}

static int set_numbers(const struct dx_config_key *key, void *base, const char *text)
{
    int word;

    if (!find_word(key, text, &word))
        return dx_config_value_set_item(key, base, 0, text);
    memset(field(key, base), 0, key->size);
    if (key->other)
        *((bool *)base + key->other) = false;
    return 0;
}

int dx_config_value_set_item(const struct dx_config_key *key, void *base, unsigned i,
                             const char *text)
{
    double *v = field(key, base);
    double item;
    int r = read_number(key, text, &item);

    if (r)
        return r;
    if (i == 0)
        memset(v, 0, key->size);
    v[i] = item;
    if (key->other)
        *((bool *)base + key->other) = true;
    return 0;
}

static int set_choice(const struct dx_config_key *key, void *base, const char *text)
{
    int word;
    uint8_t byte;

    if (!find_word(key, text, &word))
        return -EINVAL;
    byte = (uint8_t)word;
    memcpy(field(key, base), key->size == 1 ? (void *)&byte : (void *)&word, key->size);
    return 0;
}

static int set_bool(const struct dx_config_key *key, void *base, const char *text)
{
    static const char *const words[] = {"no", "yes", "false", "true", "off", "on"};

    for (unsigned i = 0; i < sizeof(words) / sizeof(words[0]); i++) {
        if (!strcmp(text, words[i])) {
            *(bool *)field(key, base) = i % 2;
            return 0;
        }
    }
    return -EINVAL;
}

static int set_size(const struct dx_config_key *key, void *base, const char *text)
{
    uint64_t width = 0, height = 0;
    int word;

    if (!find_word(key, text, &word)) {
        if (read_whole(key, &text, &width) || *text++ != 'x' || read_whole(key, &text, &height) ||
            *text || width * height > DX_PLANE_MAX_DEXELS)
            return -EINVAL;
    }
    *(uint32_t *)field(key, base) = (uint32_t)width;
    *(uint32_t *)((char *)base + key->other) = (uint32_t)height;
    return 0;
}

static int set_text(const struct dx_config_key *key, void *base, const char *text)
{
    size_t len = strlen(text);
    char *copy;

    if (len < (size_t)key->min || len > (size_t)key->max)
        return -EINVAL;
    for (const char *p = text; key->type == DX_CONFIG_NAME && *p; p++)
        if (!(isascii(*p) && isalnum((unsigned char)*p)) && !strchr("._-", *p))
            return -EINVAL;
    copy = strdup(text);
    if (!copy)
        return -ENOMEM;
    dx_config_value_free(key, base);
    memcpy(field(key, base), &copy, sizeof(copy));
    return 0;
}

int dx_config_value_set(const struct dx_config_key *key, void *base, const char *text)
{
    switch (key->type) {
    case DX_CONFIG_BOOL:
        return set_bool(key, base, text);
    case DX_CONFIG_UINT:
        return set_uint(key, base, text);
    case DX_CONFIG_NUMBER:
        return set_number(key, base, text);
    case DX_CONFIG_NUMBERS:
        return set_numbers(key, base, text);
    case DX_CONFIG_CHOICE:
        return set_choice(key, base, text);
    case DX_CONFIG_SIZE:
        return set_size(key, base, text);
    case DX_CONFIG_NAME:
    case DX_CONFIG_PATH:
        return set_text(key, base, text);
    case DX_CONFIG_MAP:
    case DX_CONFIG_DRIVER:
    case DX_CONFIG_STREAMS:
        break;
    }
    return -EINVAL;
}

int dx_config_value_preset(const struct dx_config_key *key, void *base)
{
    return key->preset ? dx_config_value_set(key, base, key->preset) : 0;
}

void dx_config_value_free(const struct dx_config_key *key, void *base)
{
    void *text;

    if (key->type != DX_CONFIG_NAME && key->type != DX_CONFIG_PATH)
        return;
    memcpy(&text, field(key, base), sizeof(text));
    free(text);
    memset(field(key, base), 0, sizeof(text));
}
