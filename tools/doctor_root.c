/* Files of the machine that `dexel doctor` looks at. */
#include "tools/doctor.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

void dx_doctor_path(const struct dx_doctor *d, char *out, size_t len, const char *path)
{
    snprintf(out, len, "%s%s", d->root, path);
}

bool dx_doctor_read(const struct dx_doctor *d, const char *path, char *text, size_t len)
{
    char whole[PATH_MAX];
    size_t n;
    FILE *f;

    *text = 0;
    dx_doctor_path(d, whole, sizeof(whole), path);
    f = fopen(whole, "re");
    if (!f)
        return false;
    n = fread(text, 1, len - 1, f);
    fclose(f);
    while (n > 0 && isspace((unsigned char)text[n - 1]))
        n--;
    text[n] = 0;
    return true;
}

bool dx_doctor_read_at(const struct dx_doctor *d, const char *folder, const char *name, char *text,
                       size_t len)
{
    char path[PATH_MAX];

    snprintf(path, sizeof(path), "%s/%s", folder, name);
    return dx_doctor_read(d, path, text, len);
}

bool dx_doctor_stat(const struct dx_doctor *d, const char *path, struct stat *st)
{
    char whole[PATH_MAX];

    dx_doctor_path(d, whole, sizeof(whole), path);
    return stat(whole, st) == 0;
}

size_t dx_doctor_glob(const struct dx_doctor *d, const char *pattern, glob_t *g)
{
    char whole[PATH_MAX];

    *g = (glob_t){0};
    dx_doctor_path(d, whole, sizeof(whole), pattern);
    return glob(whole, 0, NULL, g) == 0 ? g->gl_pathc : 0;
}

const char *dx_doctor_match(const struct dx_doctor *d, const glob_t *g, size_t k)
{
    return g->gl_pathv[k] + strlen(d->root);
}

bool dx_doctor_line(const char *text, const char *key, char *value, size_t len)
{
    const size_t key_len = strlen(key);

    for (const char *p = text; *p; p += strcspn(p, "\n"), p += *p == '\n') {
        size_t n;

        if (strncmp(p, key, key_len))
            continue;
        p += key_len;
        p += strspn(p, " \t");
        n = strcspn(p, "\n");
        while (n > 0 && isspace((unsigned char)p[n - 1]))
            n--;
        snprintf(value, len, "%.*s", (int)n, p);
        return true;
    }
    return false;
}

bool dx_doctor_fact(const struct dx_doctor *d, const char *key, char *text, size_t len)
{
    char facts[1024], start[PATH_MAX];

    snprintf(start, sizeof(start), "%s ", key);
    return *d->root && dx_doctor_read(d, "/facts", facts, sizeof(facts)) &&
           dx_doctor_line(facts, start, text, len);
}

void dx_doctor_folder(char *folder, size_t len, const char *file)
{
    const char *slash = strrchr(file, '/');

    if (slash)
        snprintf(folder, len, "%.*s", slash == file ? 1 : (int)(slash - file), file);
    else
        snprintf(folder, len, ".");
}
