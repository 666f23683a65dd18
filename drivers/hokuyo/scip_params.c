/* PP, VV and II. */
#include "drivers/hokuyo/scip_params.h"

#include "drivers/hokuyo/scip_code.h"

#include <string.h>

#define MAX_STEPS 65535u
#define MAX_RPM   60000u
#define MAX_MM    262143u

struct field {
    const uint8_t *key, *value;
    size_t key_len, value_len;
};

/* "KEY:value;X"; false when its check character does not hold, or it is no such line. */
static bool split(struct field *f, const uint8_t *line, size_t len)
{
    const uint8_t *colon = memchr(line, ':', len);

    if (!colon || !dx_scip_sum_holds_key(line, len))
        return false;
    f->key = line;
    f->key_len = (size_t)(colon - line);
    f->value = colon + 1;
    f->value_len = (size_t)(line + len - 1 - f->value); /* without the check character */
    if (f->value_len && f->value[f->value_len - 1] == ';')
        f->value_len--;
    while (f->value_len && *f->value == ' ') {
        f->value++;
        f->value_len--;
    }
    return true;
}

static bool is_key(const struct field *f, const char *key)
{
    return f->key_len == strlen(key) && !memcmp(f->key, key, f->key_len);
}

/* Printable characters up to one of `ends`. */
static void copy_text(char *out, size_t out_len, const struct field *f, const char *ends)
{
    size_t n = 0;

    while (n < f->value_len && n + 1 < out_len && !strchr(ends, f->value[n])) {
        out[n] = f->value[n] >= 0x20 && f->value[n] < 0x7F ? (char)f->value[n] : '?';
        n++;
    }
    out[n] = 0;
}

static bool read_number(uint32_t *out, const struct field *f)
{
    uint32_t v = 0;
    size_t n = 0;

    for (; n < f->value_len && f->value[n] >= '0' && f->value[n] <= '9'; n++) {
        if (n == 7)
            return false;
        v = 10 * v + (uint32_t)(f->value[n] - '0');
    }
    *out = v;
    return n > 0;
}

bool dx_scip_params_good(const struct dx_scip_params *p)
{
    return p->ares >= 16 && p->ares <= MAX_STEPS && p->amin <= p->amax && p->amax <= MAX_STEPS &&
           p->amax - p->amin < p->ares && p->afrt <= MAX_STEPS && p->dmin < p->dmax &&
           p->dmax <= MAX_MM && p->scan_rpm >= 1 && p->scan_rpm <= MAX_RPM;
}

static enum dx_scip_class class_of(const char *model)
{
    return !strncmp(model, "UTM", 3) || !strncmp(model, "UST", 3) || !strncmp(model, "UXM", 3)
               ? DX_SCIP_CLASS_UTM
               : DX_SCIP_CLASS_URG;
}

bool dx_scip_read_params(struct dx_scip_params *p, struct dx_scip_cursor lines)
{
    const struct {
        const char *key;
        uint32_t *value;
    } numbers[] = {{"DMIN", &p->dmin},    {"DMAX", &p->dmax}, {"ARES", &p->ares},
                   {"AMIN", &p->amin},    {"AMAX", &p->amax}, {"AFRT", &p->afrt},
                   {"SCAN", &p->scan_rpm}};
    const unsigned all = (1u << (sizeof(numbers) / sizeof(numbers[0]))) - 1;
    unsigned seen = 0;
    const uint8_t *line;
    size_t len;

    *p = (struct dx_scip_params){0};
    while (dx_scip_next_line(&lines, &line, &len)) {
        struct field f;

        if (!split(&f, line, len))
            return false;
        if (is_key(&f, "MODL"))
            copy_text(p->model, sizeof(p->model), &f, "(");
        for (unsigned k = 0; k < sizeof(numbers) / sizeof(numbers[0]); k++)
            if (is_key(&f, numbers[k].key) && read_number(numbers[k].value, &f))
                seen |= 1u << k;
    }
    p->class = class_of(p->model);
    return seen == all && dx_scip_params_good(p);
}

bool dx_scip_read_identity(struct dx_scip_identity *id, struct dx_scip_cursor lines)
{
    const uint8_t *line;
    size_t len;

    *id = (struct dx_scip_identity){{0}, {0}};
    while (dx_scip_next_line(&lines, &line, &len)) {
        struct field f;

        if (!split(&f, line, len))
            return false;
        if (is_key(&f, "SERI"))
            copy_text(id->serial, sizeof(id->serial), &f, "");
        else if (is_key(&f, "FIRM"))
            copy_text(id->firmware, sizeof(id->firmware), &f, "");
    }
    return true;
}

/* The texts of scanners in health differ by model. */
static bool is_healthy(const char *text)
{
    return strstr(text, "no error") || strstr(text, "works well") || strstr(text, "normally");
}

bool dx_scip_read_trouble(char *text, size_t text_len, struct dx_scip_cursor lines)
{
    const uint8_t *line;
    size_t len;

    text[0] = 0;
    while (dx_scip_next_line(&lines, &line, &len)) {
        struct field f;

        if (!split(&f, line, len))
            return false;
        if (is_key(&f, "STAT"))
            copy_text(text, text_len, &f, "");
    }
    if (is_healthy(text))
        text[0] = 0;
    return true;
}
