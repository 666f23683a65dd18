/* Coarse keys give places; what is next to each other is then compared exactly. */
#include "core/cloud/angle_order.h"

#include "core/cloud/few_sort.h"

#include <stdbool.h>

#define INDEX_BITS 8  /* of a key, so that no two are equal */
#define KEY_BITS   21 /* of a quarter turn */

static int quadrant(struct dx_flat p)
{
    if (p.x > 0 && p.y >= 0)
        return 0;
    if (p.x <= 0 && p.y > 0)
        return 1;
    return p.x < 0 ? 2 : 3;
}

static bool is_before(const struct dx_flat *at, const uint32_t *number, uint32_t a, uint32_t b)
{
    const int64_t turn = dx_flat_cross(at[a], at[b]);
    const int qa = quadrant(at[a]), qb = quadrant(at[b]);
    int64_t aa, bb;

    if (qa != qb)
        return qa < qb;
    if (turn != 0)
        return turn > 0;
    aa = dx_flat_dot(at[a], at[a]);
    bb = dx_flat_dot(at[b], at[b]);
    return aa != bb ? aa < bb : number[a] < number[b];
}

void dx_angle_order(uint8_t *order, const struct dx_flat *at, const uint32_t *number, uint32_t n)
{
    int32_t key[DX_ANGLE_ORDER_MAX], place[DX_ANGLE_ORDER_MAX];

    for (uint32_t i = 0; i < n; i++) {
        const int32_t coarse = (int32_t)(dx_angle_key(at[i]) * ((1 << KEY_BITS) - 1));

        key[i] = (int32_t)((uint32_t)coarse << INDEX_BITS | i);
    }
    for (uint32_t i = n; i % DX_FEW_LANES; i++)
        key[i] = 0; /* is not counted */
    dx_few_places(place, key, n);
    for (uint32_t i = 0; i < n; i++)
        order[place[i]] = (uint8_t)i;
    for (uint32_t i = 1; i < n; i++) {
        const uint8_t x = order[i];
        uint32_t j = i;

        for (; j > 0 && is_before(at, number, x, order[j - 1]); j--)
            order[j] = order[j - 1];
        order[j] = x;
    }
}
