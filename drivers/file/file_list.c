/* Files of a source. Sorted by bytes: alphasort and glob would sort by the locale. */
#include "drivers/file/file_list.h"

#include "drivers/file/format.h"

#include <dirent.h>
#include <errno.h>
#include <glob.h>
#include <stdlib.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

static int compare_paths(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* Takes `path`, which may be NULL (no memory). */
static int append(struct dx_file_list *list, char *path)
{
    char **paths;

    if (!path)
        return -ENOMEM;
    paths = realloc(list->paths, (list->n + 1) * sizeof(*paths));
    if (!paths) {
        free(path);
        return -ENOMEM;
    }
    list->paths = paths;
    list->paths[list->n++] = path;
    return 0;
}

static char *join(const char *dir, const char *name)
{
    char *path = NULL;
    size_t len = strlen(dir);

    return asprintf(&path, "%s%s%s", dir, len && dir[len - 1] == '/' ? "" : "/", name) < 0 ? NULL
                                                                                           : path;
}

static int list_directory(struct dx_file_list *list, const char *path, struct dx_err *err)
{
    DIR *dir = opendir(path);
    struct dirent *entry;
    int rc = 0;

    if (!dir)
        return dx_err_set(err, -errno, "%s: %s", path, strerror(errno));
    while (rc == 0 && (entry = readdir(dir)) != NULL)
        if (entry->d_name[0] != '.' &&
            (dx_format_knows_name(entry->d_name) || dx_format_has_ext(entry->d_name, ".mcap")))
            rc = append(list, join(path, entry->d_name));
    closedir(dir);
    if (rc)
        return dx_err_set(err, rc, "%s: no memory for the names of its files", path);
    if (list->n == 0)
        return dx_err_set(
            err, -ENOENT,
            "%s: no recording in this directory, expected *.ptx or *.pcd (or .gz), or *.mcap",
            path);
    return 0;
}

static int list_glob(struct dx_file_list *list, const char *pattern, struct dx_err *err)
{
    glob_t found = {0};
    int rc = glob(pattern, GLOB_NOSORT, NULL, &found);

    if (rc == GLOB_NOMATCH)
        return dx_err_set(err, -ENOENT, "%s: no such file, and none matches", pattern);
    if (rc) {
        globfree(&found);
        return dx_err_set(err, rc == GLOB_NOSPACE ? -ENOMEM : -EIO, "%s: cannot list the files",
                          pattern);
    }
    for (size_t k = 0; k < found.gl_pathc && rc == 0; k++)
        rc = append(list, strdup(found.gl_pathv[k]));
    globfree(&found);
    return rc ? dx_err_set(err, rc, "%s: no memory for the names of its files", pattern) : 0;
}

static int list_file(struct dx_file_list *list, const char *path, const struct stat *st,
                     struct dx_err *err)
{
    if (!S_ISREG(st->st_mode))
        return dx_err_set(err, -EINVAL, "%s: neither a file nor a directory", path);
    if (append(list, strdup(path)))
        return dx_err_set(err, -ENOMEM, "%s: no memory for its name", path);
    return 0;
}

int dx_file_list_init(struct dx_file_list *list, const char *path, struct dx_err *err)
{
    struct stat st;
    int rc;

    *list = (struct dx_file_list){0};
    if (stat(path, &st) == 0)
        rc =
            S_ISDIR(st.st_mode) ? list_directory(list, path, err) : list_file(list, path, &st, err);
    else if (errno == ENOENT && strpbrk(path, "*?["))
        rc = list_glob(list, path, err);
    else
        rc = dx_err_set(err, -errno, "%s: %s", path, strerror(errno));
    if (rc) {
        dx_file_list_fini(list);
        return rc;
    }
    qsort(list->paths, list->n, sizeof(*list->paths), compare_paths);
    return 0;
}

void dx_file_list_remove(struct dx_file_list *list, size_t k)
{
    free(list->paths[k]);
    list->n--;
    memmove(&list->paths[k], &list->paths[k + 1], (list->n - k) * sizeof(*list->paths));
}

void dx_file_list_fini(struct dx_file_list *list)
{
    for (size_t k = 0; k < list->n; k++)
        free(list->paths[k]);
    free(list->paths);
    *list = (struct dx_file_list){0};
}
