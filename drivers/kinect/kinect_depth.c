/* Codes of the camera to depths. */
#include "drivers/kinect/kinect_depth.h"

#include <math.h>
#include <string.h>

const char *dx_kinect_constants_wrong(const struct dx_kinect_constants *c)
{
    /* Comparisons that NaN fails. */
    if (!(c->emitter_cm >= 0.1f && c->emitter_cm <= 1000))
        return "distance of the projector";
    if (!(c->reference_mm >= 1 && c->reference_mm <= 100000))
        return "reference distance";
    if (!(c->pixel_mm >= 1e-6f && c->pixel_mm <= 100))
        return "size of a pixel";
    return c->shift < DX_KINECT_N_CODES ? NULL : "shift";
}

static uint16_t depth_mm(const struct dx_kinect_constants *c, uint32_t code, double max_mm)
{
    double x = ((double)code - 4.0 * c->shift) / 4 - 0.375;
    double m = x * (double)c->pixel_mm;
    double mm =
        10 * (m * (double)c->reference_mm / ((double)c->emitter_cm - m) + (double)c->reference_mm);

    return mm > 0 && mm <= max_mm ? (uint16_t)rint(mm) : 0;
}

void dx_kinect_lut_fill(uint16_t lut[DX_KINECT_N_CODES], const struct dx_kinect_constants *c,
                        int bits, double max_mm)
{
    uint32_t n = 1u << bits;

    max_mm = max_mm < 65535 ? max_mm : 65535;
    for (uint32_t code = 0; code < DX_KINECT_N_CODES; code++)
        lut[code] = code + 1 < n ? depth_mm(c, code, max_mm) : 0; /* the last one: no data */
}

static inline uint64_t get_be64(const uint8_t *p)
{
    uint64_t v;

    memcpy(&v, p, sizeof(v));
    return __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? __builtin_bswap64(v) : v;
}

/* 8 codes in 11 bytes: five from the first 8 bytes, three from the last 8. */
static void unpack11(uint16_t *out, const uint8_t *p, size_t n, const uint16_t *lut)
{
    for (size_t k = 0; k < n; k += 8, p += 11) {
        uint64_t a = get_be64(p), b = get_be64(p + 3);

        out[k] = lut[a >> 53];
        out[k + 1] = lut[a >> 42 & 2047];
        out[k + 2] = lut[a >> 31 & 2047];
        out[k + 3] = lut[a >> 20 & 2047];
        out[k + 4] = lut[a >> 9 & 2047];
        out[k + 5] = lut[b >> 22 & 2047];
        out[k + 6] = lut[b >> 11 & 2047];
        out[k + 7] = lut[b & 2047];
    }
}

/* 8 codes in 10 bytes. */
static void unpack10(uint16_t *out, const uint8_t *p, size_t n, const uint16_t *lut)
{
    for (size_t k = 0; k < n; k += 8, p += 10) {
        uint64_t a = get_be64(p), b = get_be64(p + 2);

        out[k] = lut[a >> 54];
        out[k + 1] = lut[a >> 44 & 1023];
        out[k + 2] = lut[a >> 34 & 1023];
        out[k + 3] = lut[a >> 24 & 1023];
        out[k + 4] = lut[a >> 14 & 1023];
        out[k + 5] = lut[b >> 20 & 1023];
        out[k + 6] = lut[b >> 10 & 1023];
        out[k + 7] = lut[b & 1023];
    }
}

void dx_kinect_unpack(uint16_t *out, const uint8_t *packed, size_t n, int bits,
                      const uint16_t lut[DX_KINECT_N_CODES])
{
    if (bits == 11)
        unpack11(out, packed, n, lut);
    else
        unpack10(out, packed, n, lut);
}

void dx_kinect_blank(uint16_t *out, size_t from, size_t to, int bits)
{
    size_t width = (size_t)bits, first = from * 8 / width, end = (to * 8 + width - 1) / width;

    end = end < DX_KINECT_PIXELS ? end : DX_KINECT_PIXELS;
    if (first < end)
        memset(out + first, 0, (end - first) * sizeof(*out));
}
