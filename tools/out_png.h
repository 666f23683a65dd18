/* Writes an image as PNG; the file is whole or not there (out_file.h). */
#ifndef DX_OUT_PNG_H
#define DX_OUT_PNG_H

#include "core/base/err.h"

#include <stdint.h>

/* rgb [height][width][3]. Errors: -errno with text. */
int dx_out_png(const char *path, const uint8_t *rgb, uint32_t width, uint32_t height,
               struct dx_err *err);

/* The same in 32 steps a channel, by a map of colours where 256 are enough: a much smaller file. */
int dx_out_png_few(const char *path, const uint8_t *rgb, uint32_t width, uint32_t height,
                   struct dx_err *err);

#endif
