/* Commands that `dexel doctor` proposes. Paths and names are words of others: no shell may take
 * them for anything else. */
#include "tools/doctor.h"

#include "core/base/plain_text.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define PLAIN "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789/._-+:,%"

static bool put(struct dx_doctor *d, size_t *len, const char *text, size_t text_len)
{
    if (*len + text_len >= sizeof(d->command))
        return false;
    memcpy(d->command + *len, text, text_len);
    *len += text_len;
    return true;
}

/* A word that begins as an option is no option. One that holds a command to the terminal cannot be
 * shown as it is. */
static bool put_word(struct dx_doctor *d, size_t *len, const char *word)
{
    char plain[PATH_MAX];
    bool fits;

    snprintf(plain, sizeof(plain), "%s", word);
    dx_plain_text(plain, strlen(plain));
    if (strcmp(plain, word))
        return false;
    if (*word == '-' && !put(d, len, "./", 2))
        return false;
    if (*word && !word[strspn(word, PLAIN)])
        return put(d, len, word, strlen(word));
    fits = put(d, len, "'", 1);
    for (; fits && *word; word++)
        fits = *word == '\'' ? put(d, len, "'\\''", 4) : put(d, len, word, 1);
    return fits && put(d, len, "'", 1);
}

/* Half a command may be another one: what does not fit is none. */
const char *dx_doctor_command(struct dx_doctor *d, const char *pattern, ...)
{
    bool fits = true;
    size_t len = 0;
    va_list words;

    va_start(words, pattern);
    for (const char *p = pattern; fits && *p; p++)
        fits = *p == '@' ? put_word(d, &len, va_arg(words, const char *)) : put(d, &len, p, 1);
    va_end(words);
    d->command[len] = 0;
    return fits ? d->command : NULL;
}

const char *dx_doctor_ask_command(struct dx_doctor *d, const char *pattern, const char *word)
{
    const char *path = dx_doctor_control_path(d);
    char named[128];

    if (!d->control && !strcmp(path, "/run/dexeld/control.sock"))
        return dx_doctor_command(d, pattern, word);
    snprintf(named, sizeof(named), "%s --socket @", pattern);
    return dx_doctor_command(d, named, word, path);
}

const char *dx_doctor_edit_command(struct dx_doctor *d)
{
    const char *path = d->config_path;

    return path ? dx_doctor_command(d, "sudoedit @ && dexeld -c @ --check", path, path) : NULL;
}
