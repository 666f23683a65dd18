/*
 * A depth image (16-bit grey PNG, or PGM with two bytes a sample) as an organized PCD, by the
 * pinhole that the caller names. compare_scans.sh runs it: depth images are no format of dexel's.
 */
#include "core/base/bytes.h"

#include <math.h>
#include <png.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_SIDE 16384u

struct image {
    uint32_t width, height;
    uint8_t *be16; /* [height][width], big-endian, as both formats have them; 0: no return */
};

struct pinhole {
    double unit_m, fx, fy, cx, cy; /* metres a level; pixels */
};

static bool reserve(struct image *m, uint32_t width, uint32_t height)
{
    if (width < 1 || height < 1 || width > MAX_SIDE || height > MAX_SIDE)
        return false;
    m->width = width;
    m->height = height;
    m->be16 = malloc(2 * (size_t)width * height);
    return m->be16 != NULL;
}

/* libpng's errors jump back here. */
static bool read_png_rows(struct image *m, png_structp png, png_infop info)
{
    if (setjmp(png_jmpbuf(png)))
        return false;
    png_read_info(png, info);
    if (png_get_bit_depth(png, info) != 16 ||
        png_get_color_type(png, info) != PNG_COLOR_TYPE_GRAY ||
        png_get_interlace_type(png, info) != PNG_INTERLACE_NONE ||
        !reserve(m, png_get_image_width(png, info), png_get_image_height(png, info)))
        return false;
    for (uint32_t i = 0; i < m->height; i++)
        png_read_row(png, m->be16 + 2 * (size_t)i * m->width, NULL);
    return true;
}

static bool read_png(struct image *m, FILE *f)
{
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    bool ok = false;

    if (info) {
        png_init_io(png, f);
        ok = read_png_rows(m, png, info);
    }
    png_destroy_read_struct(&png, &info, NULL);
    return ok;
}

static bool read_pgm(struct image *m, FILE *f)
{
    uint32_t width, height, largest;

    if (fscanf(f, "P5 %u %u %u", &width, &height, &largest) != 3 || largest < 256 ||
        fgetc(f) == EOF || !reserve(m, width, height))
        return false;
    return fread(m->be16, 2, (size_t)width * height, f) == (size_t)width * height;
}

static bool read_image(struct image *m, const char *path)
{
    FILE *f = fopen(path, "rb");
    int first = f ? fgetc(f) : EOF;
    bool ok = false;

    *m = (struct image){0};
    if (first != EOF) {
        rewind(f);
        ok = first == 'P' ? read_pgm(m, f) : read_png(m, f);
    }
    if (f)
        fclose(f);
    return ok;
}

static void put_point(FILE *f, const struct image *m, const struct pinhole *c, uint32_t i,
                      uint32_t j)
{
    const uint8_t *level = m->be16 + 2 * ((size_t)i * m->width + j);
    double z = (level[0] << 8 | level[1]) * c->unit_m;
    double p[3] = {(j - c->cx) / c->fx * z, (i - c->cy) / c->fy * z, z};
    uint8_t bytes[12];

    for (int k = 0; k < 3; k++)
        dx_put_u32(bytes + 4 * k, dx_f32_bits(z > 0 ? (float)p[k] : NAN));
    fwrite(bytes, 1, sizeof(bytes), f);
}

static bool write_pcd(const char *path, const struct image *m, const struct pinhole *c)
{
    FILE *f = fopen(path, "wb");
    bool ok;

    if (!f)
        return false;
    fprintf(f,
            "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\n"
            "SIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH %u\nHEIGHT %u\n"
            "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS %u\nDATA binary\n",
            m->width, m->height, m->width * m->height);
    for (uint32_t i = 0; i < m->height; i++)
        for (uint32_t j = 0; j < m->width; j++)
            put_point(f, m, c, i, j);
    ok = !ferror(f);
    return fclose(f) == 0 && ok;
}

int main(int argc, char **argv)
{
    struct pinhole c;
    struct image m;
    bool ok;

    if (argc != 8) {
        fprintf(stderr, "usage: depth_pcd IN.png|IN.pgm OUT.pcd UNIT_M FX FY CX CY\n");
        return 2;
    }
    c = (struct pinhole){atof(argv[3]), atof(argv[4]), atof(argv[5]), atof(argv[6]), atof(argv[7])};
    if (!(c.unit_m > 0) || !(c.fx > 0) || !(c.fy > 0)) {
        fprintf(stderr, "depth_pcd: expected UNIT_M, FX and FY above 0\n");
        return 2;
    }
    ok = read_image(&m, argv[1]);
    if (!ok)
        fprintf(stderr, "depth_pcd: %s: expected a depth image of 16 bits\n", argv[1]);
    else if (!(ok = write_pcd(argv[2], &m, &c)))
        fprintf(stderr, "depth_pcd: %s: could not be written\n", argv[2]);
    free(m.be16);
    return ok ? 0 : 1;
}
