/* libpng's simplified writer. */
#include "tools/out_png.h"

#include "tools/out_file.h"

#include <errno.h>
#include <png.h>

int dx_out_png(const char *path, const uint8_t *rgb, uint32_t width, uint32_t height,
               struct dx_err *err)
{
    png_image image = {
        .version = PNG_IMAGE_VERSION, .width = width, .height = height, .format = PNG_FORMAT_RGB};
    struct dx_out_file file;
    int rc = dx_out_file_open(&file, path, err);

    if (rc < 0)
        return rc;
    if (!png_image_write_to_stdio(&image, file.stream, 0, rgb, 0, NULL)) {
        dx_out_file_abort(&file);
        return dx_err_set(err, -EIO, "%s: %s", path, image.message);
    }
    return dx_out_file_commit(&file, err);
}
