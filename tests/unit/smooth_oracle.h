/*
 * Smoothing from its definition (docs/terrain.md), a dexel at a time over the whole frame: simple
 * and slow. What is joined comes from the oracle of terrain mode; it shares no code with core/grid
 * but directions. f32 in the order that the page gives, so that it must be the same to the bit.
 * cmocka.h comes before.
 */
#ifndef DX_TEST_SMOOTH_ORACLE_H
#define DX_TEST_SMOOTH_ORACLE_H

#include "terrain_oracle_frame.h"

static const int oracle_pairs[10][2] = {{0, 1}, {1, 0}, {1, 1},  {1, -1}, {0, 2},
                                        {2, 0}, {1, 2}, {1, -2}, {2, 1},  {2, -1}};

/* Along the row to the column, then along the column. */
static inline bool is_connected(const struct oracle *o, int64_t i, int64_t j, int di, int dj)
{
    const int row = di < 0 ? -1 : 1, col = dj < 0 ? -1 : 1;

    for (int k = 0; k != dj; k += col)
        if (!is_joined(o, LINE_H, i, j + k, col))
            return false;
    for (int k = 0; k != di; k += row)
        if (!is_joined(o, LINE_V, i + k, j + dj, row))
            return false;
    return true;
}

static inline float inverse_of(const struct oracle *o, int64_t k)
{
    return 1.0f / (float)o->range[k];
}

/* What a pair tells on an even grid: the row's line at the first column that the pair fits in. */
static inline float told_evenly(const struct oracle *o, int64_t i, const int p[2], float before,
                                float after)
{
    const int64_t j = p[1] < 0 ? -p[1] : p[1];
    double d0[3], dm[3], dp[3], a, b, c, x, y, det;
    float minus = 0, plus = 0;

    if (2 * j >= o->g->width)
        return 0;
    linear_direction(o->g, dexel(o, i, j), d0);
    linear_direction(o->g, dexel(o, i - p[0], j - p[1]), dm);
    linear_direction(o->g, dexel(o, i + p[0], j + p[1]), dp);
    a = dot(dm, dm), b = dot(dm, dp), c = dot(dp, dp), x = dot(d0, dm), y = dot(d0, dp);
    det = a * c - b * b;
    if (det > 0) {
        minus = (float)weight_of((x * c - y * b) / det) * 0x1p-24f;
        plus = (float)weight_of((y * a - x * b) / det) * 0x1p-24f;
    }
    return minus * before + plus * after;
}

static inline void f32_direction(const struct oracle *o, int64_t k, float d[3])
{
    double v[3];

    linear_direction(o->g, k, v);
    for (int n = 0; n < 3; n++)
        d[n] = (float)v[n];
}

/* From the neighbour before to the one after on a line, as far as they are joined: of directions
 * and of inverse range. */
static inline float step_along(const struct oracle *o, enum line e, int64_t i, int64_t j,
                               float d[3])
{
    const int64_t k[3] = {along(o, e, i, j, -1), dexel(o, i, j), along(o, e, i, j, 1)};
    float own[3], rise = 0;

    f32_direction(o, k[1], own);
    d[0] = d[1] = d[2] = 0;
    for (int n = -1; n <= 1; n += 2) {
        float other[3];

        if (!is_joined(o, e, i, j, n))
            continue;
        f32_direction(o, k[1 + n], other);
        for (int m = 0; m < 3; m++)
            d[m] += (float)n * (other[m] - own[m]);
        rise += (float)n * (inverse_of(o, k[1 + n]) - inverse_of(o, k[1]));
    }
    return rise;
}

static inline float dot32(const float x[3], const float y[3])
{
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

/* The vector that is in keeping with both steps, and lies in their plane. */
static inline void slope_of(const struct oracle *o, int64_t i, int64_t j, float slope[3])
{
    float a[3], b[3], p, q, aa, ab, bb, det;

    p = step_along(o, LINE_H, i, j, a);
    q = step_along(o, LINE_V, i, j, b);
    aa = dot32(a, a), ab = dot32(a, b), bb = dot32(b, b);
    det = aa * bb * 1.001f - ab * ab + 1e-30f;
    for (int n = 0; n < 3; n++)
        slope[n] = (bb * p - ab * q) / det * a[n] + (aa * q - ab * p) / det * b[n];
}

/* By the three directions' own places: how far the own one is along the line of the others, and how
 * far off it. */
static inline float told_unevenly(const struct oracle *o, const int64_t k[3], const float slope[3],
                                  float before, float after)
{
    const float arc = o->g->model == DX_MODEL_PINHOLE ? 0 : 0.5f;
    float d[3][3], whole[3], own[3], off[3], length2, x, y;

    for (int m = 0; m < 3; m++)
        f32_direction(o, k[m], d[m]);
    for (int n = 0; n < 3; n++) {
        whole[n] = d[2][n] - d[0][n];
        own[n] = d[1][n] - d[0][n];
    }
    length2 = dot32(whole, whole);
    x = dot32(own, whole) / (length2 + 1e-30f);
    x = x < 0 ? 0 : x;
    y = x > 1 ? 0 : 1 - x;
    x = 1 - y;
    for (int n = 0; n < 3; n++)
        off[n] = own[n] - x * whole[n];
    return (1 + arc * x * y * length2) * (y * before + x * after) + dot32(off, slope);
}

struct pairs {
    float departure[10], weight[10];
};

/* Departures in cutoffs; a pair that is not connected has no weight. */
static inline void see_pairs(struct pairs *out, const struct oracle *o, int64_t i, int64_t j,
                             float scale)
{
    static const float weight[10] = {1.413f, 1.413f, 0.999f, 0.999f, 0.499f,
                                     0.499f, 0.352f, 0.352f, 0.352f, 0.352f};
    float slope[3];

    slope_of(o, i, j, slope);
    for (int n = 0; n < 10; n++) {
        const int *p = oracle_pairs[n];
        const int64_t k[3] = {dexel(o, i - p[0], j - p[1]), dexel(o, i, j),
                              dexel(o, i + p[0], j + p[1])};
        float before, after, told;

        out->departure[n] = out->weight[n] = 0;
        if (!is_connected(o, i, j, p[0], p[1]) || !is_connected(o, i, j, -p[0], -p[1]))
            continue;
        before = inverse_of(o, k[0]);
        after = inverse_of(o, k[2]);
        told = o->uneven ? told_unevenly(o, k, slope, before, after)
                         : told_evenly(o, i, p, before, after);
        told = (told - inverse_of(o, k[1])) * scale;
        out->departure[n] = told > 1024 ? 1024 : told < -1024 ? -1024 : told;
        out->weight[n] = weight[n];
    }
}

/* What to begin with besides where hardly a pair speaks for the own sample and all agree. */
static inline float doubted(const struct pairs *p, float total)
{
    float all = 0, told = 0, squares = 0, spread2;

    for (int n = 0; n < 10; n++) {
        all += p->weight[n];
        told += p->weight[n] * p->departure[n];
        squares += p->weight[n] * p->departure[n] * p->departure[n];
    }
    told /= all + 1e-30f;
    spread2 = squares / (all + 1e-30f) - told * told;
    return total < 2 && spread2 < 0.25f ? (2 - total) * (1 - 4 * spread2) * told : 0;
}

static inline float robust_mean(const struct pairs *p)
{
    float shift = 0;

    for (int step = 0; step < 3; step++) {
        float total = 1, sum = 0;

        for (int n = 0; n < 10; n++) {
            const float off = p->departure[n] - shift, near = 1 - off * off;
            const float w = near > 0 ? near * near * p->weight[n] : 0;

            total += w;
            sum += w * p->departure[n];
        }
        shift = sum / total;
        shift += step == 0 ? doubted(p, total) : 0;
    }
    return shift;
}

/* The smoothed range of dexel (i,j). `noise`: of the samples, in sigmas of a single one. */
static inline uint32_t oracle_smoothed(const struct oracle *o, int64_t i, int64_t j, double noise)
{
    const int64_t k = dexel(o, i, j), most = o->g->range_bytes == 2 ? UINT16_MAX : UINT32_MAX;
    const float range = (float)o->range[k], limit = 3 / 3.5f;
    float sigma = (float)(noise / 256) * (float)(int64_t)o->noise8[k], shift, move;
    struct pairs pairs;
    int64_t to;

    if (!o->range[k])
        return 0;
    sigma = sigma > 0.5f ? sigma : 0.5f;
    see_pairs(&pairs, o, i, j, range * range / (3.5f * sigma));
    shift = robust_mean(&pairs);
    shift = limit - shift < 0 ? limit : limit - (limit - shift); /* as it is rounded */
    shift = shift + limit < 0 ? -limit : (shift + limit) - limit;
    move = shift * 3.5f * sigma;
    to = (int64_t)o->range[k] - (int64_t)(move + (move < 0 ? -0.5f : 0.5f));
    return (uint32_t)(to < 1 ? 1 : to > most ? most : to);
}

#endif
