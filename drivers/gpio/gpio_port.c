/* Lines by chip and offset, or by name: what all back ends share. */
#include "drivers/gpio/gpio_port.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>

#define MAX_OFFSET  65535u
#define MAX_NAME    32 /* the kernel keeps so many bytes of a line's name, with the NUL */
#define CHIP_PREFIX "/dev/"
#define CHIP_NAME   "gpiochip"

/* The digits behind the last colon; -1: there are none, or more than an offset has. */
static long offset_of(const char *digits)
{
    long n = 0;

    if (!*digits)
        return -1;
    for (; *digits; digits++) {
        if (*digits < '0' || *digits > '9')
            return -1;
        n = n * 10 + (*digits - '0');
        if (n > (long)MAX_OFFSET)
            return -1;
    }
    return n;
}

bool dx_gpio_where_split(const char *where, char *chip, size_t chip_len, uint32_t *offset)
{
    const char *colon = strrchr(where, ':');
    size_t n = colon ? (size_t)(colon - where) : 0;
    long at = colon ? offset_of(colon + 1) : -1;
    size_t prefix_len = *where == '/' ? 0 : strlen(CHIP_PREFIX);

    if (at < 0 || n == 0 || n + prefix_len >= chip_len)
        return false;
    memcpy(chip, CHIP_PREFIX, prefix_len);
    memcpy(chip + prefix_len, where, n);
    chip[prefix_len + n] = 0;
    *offset = (uint32_t)at;
    return true;
}

const char *dx_gpio_where_check(const char *where)
{
    struct dx_gpio_place place;

    if (!dx_gpio_where_given(where))
        return "a line is CHIP:OFFSET or a name";
    for (const char *c = where; *c; c++)
        if ((unsigned char)*c <= ' ' || *c == 0x7f)
            return "a line is CHIP:OFFSET or a name, without spaces";
    if (dx_gpio_where_split(where, place.chip, sizeof(place.chip), &place.offset))
        return NULL;
    if (!strncmp(where, CHIP_NAME, strlen(CHIP_NAME)) && strchr(where, ':'))
        return "the offset of a chip's line is from 0 to 65535";
    if (*where == '/')
        return "a path of a chip needs the line's offset behind it: /dev/gpiochip0:17";
    return strlen(where) < MAX_NAME ? NULL : "names of lines have at most 31 bytes";
}

bool dx_gpio_where_same(const char *a, const char *b)
{
    struct dx_gpio_place at, bt;

    if (!dx_gpio_where_given(a) || !dx_gpio_where_given(b))
        return false;
    if (dx_gpio_where_split(a, at.chip, sizeof(at.chip), &at.offset) &&
        dx_gpio_where_split(b, bt.chip, sizeof(bt.chip), &bt.offset))
        return at.offset == bt.offset && !strcmp(at.chip, bt.chip);
    return !strcmp(a, b);
}

/* Looks through the chips in /dev. */
static bool find_name(const char *name, int (*offset_on)(const char *path, const char *name),
                      struct dx_gpio_place *place)
{
    DIR *dir = opendir("/dev");
    const struct dirent *d;
    int offset = -1;

    while (dir && offset < 0 && (d = readdir(dir))) {
        if (strncmp(d->d_name, CHIP_NAME, strlen(CHIP_NAME)))
            continue;
        if (snprintf(place->chip, sizeof(place->chip), CHIP_PREFIX "%s", d->d_name) <
            (int)sizeof(place->chip))
            offset = offset_on(place->chip, name);
    }
    if (dir)
        closedir(dir);
    place->offset = (uint32_t)offset;
    return offset >= 0;
}

int dx_gpio_find(const char *where, int (*offset_on)(const char *path, const char *name),
                 struct dx_gpio_place *place, struct dx_err *err)
{
    const char *why = dx_gpio_where_check(where);

    if (why)
        return dx_err_set(err, -EINVAL, "gpio line %s: %s", where ? where : "", why);
    if (dx_gpio_where_split(where, place->chip, sizeof(place->chip), &place->offset) ||
        (offset_on && find_name(where, offset_on, place)))
        return 0;
    return dx_gpio_fail(err, -ENOENT, where, "no chip has a line of this name");
}

int dx_gpio_fail(struct dx_err *err, int code, const char *where, const char *what)
{
    code = code ? code : -EIO; /* a library that fails without a reason has failed all the same */
    return dx_err_set(err, code, "gpio line %s: %s: %s", where, what, strerror(-code));
}
