/*
 * Files of recordings. Only names that the pattern itself could have made are ever removed: they
 * are read back with strptime.
 */
#include "daemon/record_files.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define EXT       ".mcap"
#define MAX_SAME  99999999 /* names of one time */
#define MAX_FOUND 65536

static const char *name_of(const char *pattern)
{
    const char *slash = strrchr(pattern, '/');

    return slash ? slash + 1 : pattern;
}

const char *dx_record_files_check(const char *pattern)
{
    const char *name = name_of(pattern);
    size_t len = strlen(name), ext = strlen(EXT);

    if (len <= ext || strcmp(name + len - ext, EXT))
        return "expected a name that ends in " EXT;
    for (const char *p = pattern; *p; p++) {
        if (*p != '%')
            continue;
        if (p < name)
            return "found % in the folder, expected it in the file's name alone";
        p++;
        if (!*p || !strchr("YmdHMSjFT%", *p))
            return "expected %Y %m %d %H %M %S %j %F %T or %% only";
    }
    return NULL;
}

void dx_record_files_init(struct dx_record_files *f, const char *pattern, uint64_t keep_len)
{
    *f = (struct dx_record_files){.pattern = pattern, .keep_len = keep_len, .fd = -1};
}

/* The pattern without its extension. False: too long. */
static bool stem_of(char stem[PATH_MAX], const char *pattern)
{
    size_t len = strlen(pattern) - strlen(EXT);

    if (len >= PATH_MAX)
        return false;
    memcpy(stem, pattern, len);
    stem[len] = '\0';
    return true;
}

static DIR *open_folder(const char *pattern)
{
    size_t len = (size_t)(name_of(pattern) - pattern);
    char path[PATH_MAX];

    if (len >= sizeof(path))
        return NULL;
    memcpy(path, pattern, len);
    path[len] = '\0';
    return opendir(len ? path : ".");
}

/* The number in the name of a file of this start; 1: it has none, 0: it is another's. */
static unsigned number_of(const char *name, const char *start)
{
    size_t len = strlen(start);
    unsigned long n = 1;
    char *end;

    if (strncmp(name, start, len))
        return 0;
    end = (char *)name + len;
    if (*end == '_' && end[1] >= '0' && end[1] <= '9')
        n = strtoul(end + 1, &end, 10);
    return strcmp(end, EXT) || n > MAX_SAME ? 0 : (unsigned)n;
}

/* The highest number among the files of this start, those that were removed since included. */
static unsigned last_number(const struct dx_record_files *f, const char *start)
{
    unsigned last = strcmp(f->start, start) ? 0 : f->number;
    const struct dirent *entry;
    DIR *dir = open_folder(start);

    while (dir && (entry = readdir(dir)) != NULL) {
        unsigned n = number_of(entry->d_name, name_of(start));

        last = n > last ? n : last;
    }
    if (dir)
        closedir(dir);
    return last;
}

int dx_record_files_create(struct dx_record_files *f, uint64_t unix_ns)
{
    time_t seconds = (time_t)(unix_ns / 1000000000u);
    char stem[PATH_MAX], start[PATH_MAX - 32];
    struct tm utc;

    dx_record_files_close(f);
    if (!stem_of(stem, f->pattern) || !gmtime_r(&seconds, &utc) ||
        strftime(start, sizeof(start), stem, &utc) == 0)
        return -ENAMETOOLONG;
    for (unsigned n = last_number(f, start) + 1; n <= MAX_SAME; n++) {
        if (n == 1)
            snprintf(f->path, sizeof(f->path), "%s" EXT, start);
        else
            snprintf(f->path, sizeof(f->path), "%s_%04u" EXT, start, n);
        f->fd = open(f->path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0640);
        if (f->fd < 0 && errno != EEXIST)
            return -errno;
        if (f->fd < 0)
            continue;
        (void)flock(f->fd, LOCK_EX | LOCK_NB); /* see is_written() */
        strcpy(f->start, start);
        f->number = n;
        return 0;
    }
    return -EEXIST;
}

int dx_record_files_sync(struct dx_record_files *f)
{
    return f->fd < 0 || fdatasync(f->fd) == 0 ? 0 : -errno;
}

void dx_record_files_close(struct dx_record_files *f)
{
    if (f->fd >= 0)
        close(f->fd);
    f->fd = -1;
}

/* ---- what stays ------------------------------------------------------------------------------
 */

struct found {
    char *name;
    struct timespec changed;
    uint64_t len;
};

struct folder {
    int fd;
    struct found *found;
    size_t n;
    uint64_t len; /* of all */
};

/* Could the pattern have made this name? */
static bool is_ours(const char *stem, const char *name)
{
    struct tm tm = {0};
    const char *rest = strptime(name, stem, &tm);

    if (!rest)
        return false;
    if (*rest == '_') {
        size_t digits = strspn(rest + 1, "0123456789");

        rest += digits ? 1 + digits : 0;
    }
    return !strcmp(rest, EXT);
}

static void add(struct folder *d, const char *name)
{
    struct found *more;
    struct stat st;

    if (d->n == MAX_FOUND || fstatat(d->fd, name, &st, AT_SYMLINK_NOFOLLOW) != 0 ||
        !S_ISREG(st.st_mode))
        return;
    more = realloc(d->found, (d->n + 1) * sizeof(*more));
    if (!more)
        return;
    d->found = more;
    more[d->n] = (struct found){strdup(name), st.st_mtim, (uint64_t)st.st_size};
    if (!more[d->n].name)
        return;
    d->len += more[d->n++].len;
}

static int older_first(const void *a, const void *b)
{
    const struct found *x = a, *y = b;

    if (x->changed.tv_sec != y->changed.tv_sec)
        return x->changed.tv_sec < y->changed.tv_sec ? -1 : 1;
    if (x->changed.tv_nsec != y->changed.tv_nsec)
        return x->changed.tv_nsec < y->changed.tv_nsec ? -1 : 1;
    return strcmp(x->name, y->name);
}

/* By this recorder, another stream's or another service's: whoever writes one holds its lock. */
static bool is_written(const struct folder *d, const char *name)
{
    int fd = openat(d->fd, name, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    bool is_locked = fd >= 0 && flock(fd, LOCK_SH | LOCK_NB) != 0;

    if (fd >= 0)
        close(fd);
    return is_locked;
}

static unsigned remove_oldest(const struct dx_record_files *f, struct folder *d)
{
    unsigned n_removed = 0;

    if (d->n)
        qsort(d->found, d->n, sizeof(*d->found), older_first);
    for (size_t k = 0; k < d->n && d->len > f->keep_len; k++) {
        if (is_written(d, d->found[k].name) || unlinkat(d->fd, d->found[k].name, 0) != 0)
            continue;
        d->len -= d->found[k].len;
        n_removed++;
    }
    return n_removed;
}

unsigned dx_record_files_trim(const struct dx_record_files *f)
{
    struct folder d = {0};
    char stem[PATH_MAX];
    unsigned n_removed;
    const struct dirent *entry;
    DIR *dir;

    if (!f->keep_len || !stem_of(stem, f->pattern))
        return 0;
    dir = open_folder(f->pattern);
    if (!dir)
        return 0;
    d.fd = dirfd(dir);
    while ((entry = readdir(dir)) != NULL)
        if (is_ours(name_of(stem), entry->d_name))
            add(&d, entry->d_name);
    n_removed = remove_oldest(f, &d);
    for (size_t k = 0; k < d.n; k++)
        free(d.found[k].name);
    free(d.found);
    closedir(dir);
    return n_removed;
}
