/* Strut codes: a mixed-radix number, and the polygons it stands for. */
#include "core/grid/strut.h"

#include <string.h>

uint8_t dx_strut_code(const struct dx_strut *s)
{
    return (uint8_t)DX_STRUT_CODE(s->across, s->len, s->first, s->second);
}

/* Whether a strut of this length can have the side. */
static bool fits(uint8_t side, uint8_t len)
{
    switch (side) {
    case DX_STRUT_CHAIN + 1: /* a chain of one dexel is a triangle: nothing to cut */
    case DX_STRUT_LOWER:
    case DX_STRUT_LOWER + 1:
    case DX_STRUT_SHORTER:
    case DX_STRUT_SHORTER + 1:
        return len == 2;
    case DX_STRUT_LONGER:
    case DX_STRUT_LONGER + 1:
        return len == 1;
    default:
        return true;
    }
}

bool dx_strut_decode(struct dx_strut *s, uint8_t code)
{
    unsigned n = code - 1u;

    if (code == 0 || code >= DX_STRUT_CODES)
        return false;
    s->second = (uint8_t)(n % DX_STRUT_SECOND_SIDES);
    n /= DX_STRUT_SECOND_SIDES;
    s->first = (uint8_t)(n % DX_STRUT_FIRST_SIDES);
    n /= DX_STRUT_FIRST_SIDES;
    s->len = (uint8_t)(1 + n % 2);
    s->across = n / 2;
    return (s->first || s->second) && fits(s->first, s->len) && fits(s->second, s->len);
}

/* Along the strut: where side[0] and side[1] are. Returns how many there are. */
static int side_points(int8_t along[2], uint8_t side, uint8_t len)
{
    switch ((side - 1) / 2) {
    case 0:
        along[0] = 0;
        along[1] = 1;
        return len;
    case 1:
        along[0] = 0;
        along[1] = 2;
        return 2;
    case 2:
        along[0] = -1;
        along[1] = (int8_t)len;
        return 2;
    case 3:
        along[0] = -1;
        along[1] = 2;
        return 2;
    default:
        along[0] = -1;
        along[1] = 1;
        return 2;
    }
}

/* One triangle of points (along, across), turned so that it runs as abc does. */
static void put(struct dx_strut_corner out[3], bool across, bool reversed, const int8_t p[3][2])
{
    for (int k = 0; k < 3; k++) {
        const int8_t *q = p[k == 0 || !reversed ? k : 3 - k];

        out[k] =
            across ? (struct dx_strut_corner){q[1], q[0]} : (struct dx_strut_corner){q[0], q[1]};
    }
}

static unsigned side_triangles(struct dx_strut_corner (*out)[3], const struct dx_strut *s,
                               uint8_t side, int8_t t)
{
    const bool reversed = (t < 0) != s->across; /* A, side, B runs as abc does on the right of a
                                                   strut down; mirrored elsewhere */
    const int8_t end = (int8_t)s->len;
    int8_t along[2];
    int n;

    if (side == DX_STRUT_OPEN)
        return 0;
    n = side_points(along, side, s->len);
    if (n == 1) {
        put(out[0], s->across, reversed, (const int8_t[3][2]){{-1, 0}, {along[0], t}, {end, 0}});
        return 1;
    }
    if (side % 2) { /* cut from A */
        put(out[0], s->across, reversed,
            (const int8_t[3][2]){{-1, 0}, {along[0], t}, {along[1], t}});
        put(out[1], s->across, reversed, (const int8_t[3][2]){{-1, 0}, {along[1], t}, {end, 0}});
    } else {
        put(out[0], s->across, reversed, (const int8_t[3][2]){{-1, 0}, {along[0], t}, {end, 0}});
        put(out[1], s->across, reversed,
            (const int8_t[3][2]){{along[0], t}, {along[1], t}, {end, 0}});
    }
    return 2;
}

static unsigned lone_triangles(struct dx_strut_corner (*out)[3], const struct dx_lone_strut *s)
{
    static const struct dx_strut_corner side[2][2][3] = {
        {{{-1, 0}, {1, 0}, {0, -1}}, {{-1, 0}, {0, 1}, {1, 0}}},
        {{{0, -1}, {-1, 0}, {0, 1}}, {{0, -1}, {0, 1}, {1, 0}}},
    };

    memcpy(out[0], side[s->across][!s->first], sizeof(*out));
    memcpy(out[1], side[s->across][1], sizeof(*out));
    return (unsigned)s->first + s->second;
}

unsigned dx_strut_triangles(struct dx_strut_corner out[DX_STRUT_MAX_TRIANGLES][3], uint8_t code)
{
    struct dx_lone_strut lone;
    struct dx_strut s;
    unsigned n;

    if (dx_strut_is_lone(&lone, code))
        return lone_triangles(out, &lone);
    if (!dx_strut_decode(&s, code))
        return 0;
    n = side_triangles(out, &s, s.first, -1);
    return n + side_triangles(out + n, &s, s.second, 1);
}
