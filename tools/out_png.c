/* libpng's simplified writer. */
#include "tools/out_png.h"

#include "tools/out_file.h"

#include <errno.h>
#include <png.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define MAX_COLOURS 256
#define BITS        5 /* of a channel, in a picture of few colours */

/* A picture of few colours: places in a map. */
struct palette {
    uint8_t rgb[MAX_COLOURS][3];
    int16_t place[1 << (3 * BITS)]; /* of a colour; -1: not there yet */
    unsigned n;
};

/* `map` NULL: pixels are RGB, else places in it. */
static int write_png(const char *path, png_image *image, const uint8_t *pixels, const void *map,
                     struct dx_err *err)
{
    struct dx_out_file file;
    int rc = dx_out_file_open(&file, path, err);

    if (rc < 0)
        return rc;
    errno = 0; /* libpng says that a write failed, but not why */
    if (!png_image_write_to_stdio(image, file.stream, 0, pixels, 0, map)) {
        rc = errno && ferror(file.stream) ? -errno : -EIO;
        dx_out_file_abort(&file);
        return dx_err_set(err, rc, "%s: cannot be written: %s", path,
                          rc == -EIO ? image->message : strerror(-rc));
    }
    return dx_out_file_commit(&file, err);
}

int dx_out_png(const char *path, const uint8_t *rgb, uint32_t width, uint32_t height,
               struct dx_err *err)
{
    png_image image = {
        .version = PNG_IMAGE_VERSION, .width = width, .height = height, .format = PNG_FORMAT_RGB};

    return write_png(path, &image, rgb, NULL, err);
}

/* Each channel to the nearest of 32 steps that reach from 0 to 255. */
static uint8_t coarse(uint8_t x)
{
    return (uint8_t)((x * 31u + 127) / 255);
}

/* The place of a colour, -1 when the map is full. */
static int place_of(struct palette *p, const uint8_t rgb[3])
{
    const unsigned r = coarse(rgb[0]), g = coarse(rgb[1]), b = coarse(rgb[2]);
    int16_t *place = &p->place[(r << BITS | g) << BITS | b];

    if (*place < 0 && p->n < MAX_COLOURS) {
        const unsigned steps[3] = {r, g, b};

        for (int k = 0; k < 3; k++)
            p->rgb[p->n][k] = (uint8_t)((steps[k] * 255 + 15) / 31);
        *place = (int16_t)p->n++;
    }
    return *place;
}

/* False: there are more colours than a map holds. */
static bool make_places(uint8_t *out, struct palette *p, const uint8_t *rgb, size_t n)
{
    memset(p->place, 0xff, sizeof(p->place));
    for (size_t k = 0; k < n; k++) {
        const int place = place_of(p, rgb + 3 * k);

        if (place < 0)
            return false;
        out[k] = (uint8_t)place;
    }
    return true;
}

int dx_out_png_few(const char *path, const uint8_t *rgb, uint32_t width, uint32_t height,
                   struct dx_err *err)
{
    const size_t n = (size_t)width * height;
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = width,
                       .height = height,
                       .format = PNG_FORMAT_RGB_COLORMAP};
    struct palette *p = calloc(1, sizeof(*p));
    uint8_t *places = malloc(n + 1);
    int rc = p && places ? 0 : dx_err_set(err, -ENOMEM, "%s: %s", path, strerror(ENOMEM));

    if (rc == 0 && make_places(places, p, rgb, n)) {
        image.colormap_entries = p->n;
        rc = write_png(path, &image, places, p->rgb, err);
    } else if (rc == 0)
        rc = dx_out_png(path, rgb, width, height, err);
    free(p);
    free(places);
    return rc;
}
