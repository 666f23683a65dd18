/*
 * Predicates of points in a plane, exact: coordinates are integers below DX_FLAT_MAX in magnitude,
 * so that nothing rounds. A predicate that says 0 means just that; what then happens is decided by
 * its caller, by the points' numbers.
 */
#ifndef DX_PREDICATES_H
#define DX_PREDICATES_H

#include <stdbool.h>
#include <stdint.h>

#define DX_FLAT_MAX (1 << 29)

struct dx_flat {
    int32_t x, y;
};

/* Of the vectors a and b: positive when b is to the left of a. */
static inline int64_t dx_flat_cross(struct dx_flat a, struct dx_flat b)
{
    return (int64_t)a.x * b.y - (int64_t)a.y * b.x;
}

static inline int64_t dx_flat_dot(struct dx_flat a, struct dx_flat b)
{
    return (int64_t)a.x * b.x + (int64_t)a.y * b.y;
}

static inline struct dx_flat dx_flat_minus(struct dx_flat a, struct dx_flat b)
{
    return (struct dx_flat){a.x - b.x, a.y - b.y};
}

/* Positive when a, b, c turn left, 0 when they are on one line. */
static inline int64_t dx_flat_turn(struct dx_flat a, struct dx_flat b, struct dx_flat c)
{
    return dx_flat_cross(dx_flat_minus(b, a), dx_flat_minus(c, a));
}

/* Direction d is strictly inside the sector that runs left from direction a to direction b. One
 * from a to a is the whole turn but a. */
bool dx_flat_in_sector(struct dx_flat a, struct dx_flat b, struct dx_flat d);

/* Segments a-b and c-d cross in a point that is inside both. */
static inline bool dx_flat_cross_inside(struct dx_flat a, struct dx_flat b, struct dx_flat c,
                                        struct dx_flat d)
{
    const int64_t abc = dx_flat_turn(a, b, c), abd = dx_flat_turn(a, b, d);

    if ((abc >= 0 && abd >= 0) || (abc <= 0 && abd <= 0))
        return false;

    const int64_t cda = dx_flat_turn(c, d, a), cdb = dx_flat_turn(c, d, b);

    return (cda > 0 && cdb < 0) || (cda < 0 && cdb > 0);
}

/* Where d is to the circle through the origin, a and b, which turn left: 1 inside, 0 on it, -1
 * outside. */
int dx_flat_in_circle(struct dx_flat a, struct dx_flat b, struct dx_flat d);

#endif
