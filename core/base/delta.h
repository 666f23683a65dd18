/*
 * The delta encoding's predictors: what encoder and decoder must do alike. Ranges are coded in rank
 * order, each as the difference to what its neighbours W (k - 1), N (k - 67) and NW (k - 68) make
 * expect. Where they are not all vertices, one range that is known stands for the three, so that
 * every predictor gives just that. All arithmetic is modulo 2^32.
 *
 * On a plane with noise of standard deviation s the differences have 2 s (planar), 1.22 s (mean) or
 * 1.41 s (left); away from the plane the order turns round. So the encoder tries all and says which
 * it took: no one of them is best in every tile.
 */
#ifndef DX_DELTA_H
#define DX_DELTA_H

#include <stdint.h>

enum dx_delta_predictor {
    DX_DELTA_PLANAR = 0, /* W + N - NW */
    DX_DELTA_MEAN = 1,   /* (W + N) / 2, rounded down */
    DX_DELTA_LEFT = 2,   /* W */
    DX_DELTA_MEDIAN = 3, /* of W, N and W + N - NW: keeps edges */
    DX_N_DELTA_PREDICTORS = 4,
};

#define DX_DELTA_BLOCK     32 /* residuals of one width */
#define DX_DELTA_MAX_WIDTH 32

static inline uint32_t dx_delta_predict(enum dx_delta_predictor predictor, uint32_t w, uint32_t n,
                                        uint32_t nw)
{
    uint32_t low = w < n ? w : n, high = w < n ? n : w;

    switch (predictor) {
    case DX_DELTA_PLANAR:
        return w + n - nw;
    case DX_DELTA_MEAN:
        return (w & n) + ((w ^ n) >> 1);
    case DX_DELTA_LEFT:
        return w;
    default:
        return nw >= high ? low : nw <= low ? high : w + n - nw;
    }
}

/* Small numbers of either sign to small ones without: 0, -1, 1, -2 ... to 0, 1, 2, 3 ... */
static inline uint32_t dx_delta_fold(uint32_t d)
{
    return d << 1 ^ -(d >> 31);
}

static inline uint32_t dx_delta_unfold(uint32_t z)
{
    return z >> 1 ^ -(z & 1);
}

#endif
