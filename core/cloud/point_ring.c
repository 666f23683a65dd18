/* Rings in an arena: a word of count and size class, then the neighbours. */
#include "core/cloud/point_ring.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define SMALLEST    8u
#define CLASS_SHIFT 16
#define NONE        UINT32_MAX

void dx_rings_init(struct dx_rings *r)
{
    *r = (struct dx_rings){.n = 1}; /* handle 0 is no ring */
}

void dx_rings_fini(struct dx_rings *r)
{
    free(r->words);
    *r = (struct dx_rings){0};
}

static uint32_t class_of(const struct dx_rings *r, uint32_t ring)
{
    return r->words[ring] >> CLASS_SHIFT;
}

static uint32_t room_of(uint32_t class)
{
    return SMALLEST << class;
}

static int grow(struct dx_rings *r, size_t n)
{
    size_t cap = r->cap ? r->cap : 4096;
    uint32_t *words;

    while (cap < n)
        cap *= 2;
    if (cap > UINT32_MAX)
        return -ENOMEM;
    words = realloc(r->words, cap * sizeof(*words));
    if (!words)
        return -ENOMEM;
    r->words = words;
    r->cap = cap;
    return 0;
}

/* A ring of this class; its list is not filled. */
static int take(struct dx_rings *r, uint32_t *ring, uint32_t class)
{
    const size_t len = 1 + room_of(class);

    if (r->free_list[class]) {
        *ring = r->free_list[class];
        r->free_list[class] = r->words[*ring + 1];
    } else {
        if (r->n + len > r->cap && grow(r, r->n + len) < 0)
            return -ENOMEM;
        *ring = (uint32_t)r->n;
        r->n += len;
        r->peak_len = r->n * sizeof(*r->words);
    }
    r->words[*ring] = class << CLASS_SHIFT;
    r->n_used++;
    r->n_peak = r->n_used > r->n_peak ? r->n_used : r->n_peak;
    return 0;
}

void dx_ring_free(struct dx_rings *r, uint32_t *ring)
{
    uint32_t class;

    if (!*ring)
        return;
    class = class_of(r, *ring);
    r->words[*ring + 1] = r->free_list[class];
    r->free_list[class] = *ring;
    r->n_used--;
    *ring = 0;
}

/* Room for `more` neighbours beside those it has. */
static int reserve(struct dx_rings *r, uint32_t *ring, uint32_t more)
{
    uint32_t n = dx_ring_n(r, *ring), class = *ring ? class_of(r, *ring) : 0, next;

    if (*ring && n + more <= room_of(class))
        return 0;
    while (n + more > room_of(class))
        class ++;
    if (take(r, &next, class) < 0)
        return -ENOMEM;
    if (n)
        memcpy(r->words + next + 1, r->words + *ring + 1, n * sizeof(uint32_t));
    r->words[next] |= n;
    dx_ring_free(r, ring);
    *ring = next;
    return 0;
}

/* Places of a and b in a list; NONE: not there. */
struct places {
    uint32_t a, b;
};

static struct places find(const uint32_t *list, uint32_t n, uint32_t a, uint32_t b)
{
    struct places at = {NONE, NONE};

    for (uint32_t k = 0; k < n; k++) {
        const uint32_t v = list[k] & ~DX_RING_FIRST;

        if (v == a)
            at.a = k;
        if (v == b)
            at.b = k;
    }
    return at;
}

static bool is_last(const uint32_t *list, uint32_t n, uint32_t k)
{
    return k + 1 == n || (list[k + 1] & DX_RING_FIRST);
}

static uint32_t first_of(const uint32_t *list, uint32_t k)
{
    while (!(list[k] & DX_RING_FIRST))
        k--;
    return k;
}

static uint32_t end_of(const uint32_t *list, uint32_t n, uint32_t k)
{
    while (!is_last(list, n, k))
        k++;
    return k + 1;
}

bool dx_ring_fits(const struct dx_rings *r, uint32_t ring, uint32_t a, uint32_t b)
{
    const uint32_t n = dx_ring_n(r, ring), *list = dx_ring_list(r, ring);
    struct places at;

    if (!n)
        return true;
    at = find(list, n, a, b);
    if (at.a != NONE && !is_last(list, n, at.a))
        return false;
    if (at.b != NONE && !(list[at.b] & DX_RING_FIRST))
        return false;
    if (at.a != NONE && at.b != NONE && first_of(list, at.a) == at.b)
        return at.b == 0 && at.a + 1 == n && n > 2; /* closes: nothing else may be there */
    return n + 2 <= DX_RING_MAX;
}

/* The chain that starts at `from` goes behind the one that ends before `to`, as its continuation.
 */
static void join(uint32_t *list, uint32_t n, uint32_t from, uint32_t to)
{
    uint32_t held[DX_RING_MAX], len = end_of(list, n, from) - from;

    memcpy(held, list + from, len * sizeof(*held));
    held[0] &= ~DX_RING_FIRST;
    if (from < to) {
        memmove(list + from, list + from + len, (to - from - len) * sizeof(*list));
        memcpy(list + to - len, held, len * sizeof(*held));
    } else {
        memmove(list + to + len, list + to, (from - to) * sizeof(*list));
        memcpy(list + to, held, len * sizeof(*held));
    }
}

static void insert(uint32_t *list, uint32_t n, uint32_t k, uint32_t v)
{
    memmove(list + k + 1, list + k, (n - k) * sizeof(*list));
    list[k] = v;
}

int dx_ring_add(struct dx_rings *r, uint32_t *ring, uint32_t a, uint32_t b)
{
    uint32_t n, *list;
    struct places at;

    if (reserve(r, ring, 2) < 0)
        return -ENOMEM;
    n = dx_ring_n(r, *ring);
    list = r->words + *ring + 1;
    at = find(list, n, a, b);
    if (at.a != NONE && at.b != NONE) {
        if (first_of(list, at.a) == at.b)
            return DX_RING_CLOSED;
        join(list, n, at.b, at.a + 1);
        return DX_RING_OPEN;
    }
    if (at.a != NONE) {
        insert(list, n, at.a + 1, b);
    } else if (at.b != NONE) {
        list[at.b] &= ~DX_RING_FIRST;
        insert(list, n, at.b, a | DX_RING_FIRST);
    } else {
        list[n] = a | DX_RING_FIRST;
        list[n + 1] = b;
        r->words[*ring]++;
    }
    r->words[*ring]++;
    return DX_RING_OPEN;
}

uint32_t dx_ring_n_chains(const struct dx_rings *r, uint32_t ring)
{
    const uint32_t n = dx_ring_n(r, ring);
    uint32_t n_chains = 0;

    for (uint32_t k = 0; k < n; k++)
        n_chains += dx_ring_list(r, ring)[k] >> 31;
    return n_chains;
}
