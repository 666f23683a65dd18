/* Sets that grow together: parent[k] == k is a root, and the root of a set is its lowest member. */
#ifndef DX_UNION_FIND_H
#define DX_UNION_FIND_H

#include <stdint.h>

static inline uint32_t dx_union_root(uint32_t *parent, uint32_t k)
{
    while (parent[k] != k) {
        parent[k] = parent[parent[k]];
        k = parent[k];
    }
    return k;
}

static inline void dx_union_join(uint32_t *parent, uint32_t a, uint32_t b)
{
    a = dx_union_root(parent, a);
    b = dx_union_root(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

#endif
