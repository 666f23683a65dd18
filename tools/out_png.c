/* libpng's simplified writer. */
#include "tools/out_png.h"

#include "tools/out_file.h"

#include <errno.h>
#include <png.h>
#include <string.h>

int dx_out_png(const char *path, const uint8_t *rgb, uint32_t width, uint32_t height,
               struct dx_err *err)
{
    png_image image = {
        .version = PNG_IMAGE_VERSION, .width = width, .height = height, .format = PNG_FORMAT_RGB};
    struct dx_out_file file;
    int rc = dx_out_file_open(&file, path, err);

    if (rc < 0)
        return rc;
    errno = 0; /* libpng says that a write failed, but not why */
    if (!png_image_write_to_stdio(&image, file.stream, 0, rgb, 0, NULL)) {
        rc = errno && ferror(file.stream) ? -errno : -EIO;
        dx_out_file_abort(&file);
        return dx_err_set(err, rc, "%s: cannot be written: %s", path,
                          rc == -EIO ? image.message : strerror(-rc));
    }
    return dx_out_file_commit(&file, err);
}
