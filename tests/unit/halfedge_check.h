/* What must hold of half-edges after every operation; for tests. */
#ifndef HALFEDGE_CHECK_H
#define HALFEDGE_CHECK_H

#include "core/cloud/halfedge.h"

#include <stdlib.h>

struct halfedge_counts {
    uint32_t n_used, n_border, n_loops, n_corners; /* n_corners: of vertices, beyond their first */
    int64_t euler;                                 /* of the used vertices */
};

static inline int halfedge_by_key(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;

    return (x > y) - (x < y);
}

/* A directed edge exists once, and none is a loop. NULL: so it is. */
static inline const char *halfedge_check_directed(const struct dx_halfedges *m)
{
    uint64_t *keys = malloc(((size_t)m->n + 1) * sizeof(*keys));
    const char *wrong = NULL;

    for (uint32_t h = 0; h < m->n; h++) {
        keys[h] = (uint64_t)dx_halfedge_from(m, h) << 32 | m->of[h].to;
        if (m->of[h].to == dx_halfedge_from(m, h) || m->of[h].to >= m->n_vertices)
            wrong = "an edge from a vertex to itself or to none";
    }
    qsort(keys, m->n, sizeof(*keys), halfedge_by_key);
    for (uint32_t h = 1; h < m->n; h++)
        if (keys[h] == keys[h - 1])
            wrong = "a directed edge twice";
    free(keys);
    return wrong;
}

static inline const char *halfedge_check_links(const struct dx_halfedges *m)
{
    uint32_t n_of_faces = 0;

    for (uint32_t h = 0; h < m->n; h++) {
        const struct dx_halfedge *e = &m->of[h];

        if (e->next >= m->n || e->prev >= m->n || m->of[e->next].prev != h ||
            m->of[e->prev].next != h)
            return "next and prev are not each other's";
        if (dx_halfedge_from(m, e->next) != e->to)
            return "next begins elsewhere";
        if (m->of[e->next].face != e->face)
            return "next is of another face";
        if (e->face == DX_NO_HALFEDGE && m->of[h ^ 1].face == DX_NO_HALFEDGE)
            return "an edge without a triangle";
        n_of_faces += e->face != DX_NO_HALFEDGE;
    }
    for (uint32_t f = 0; f < m->n_faces; f++) {
        const uint32_t h = m->face[f];

        if (h >= m->n || m->of[h].face != f || m->of[m->of[m->of[h].next].next].next != h)
            return "a face is no triangle";
    }
    return n_of_faces == 3 * m->n_faces ? NULL : "half-edges of faces that are not there";
}

/* All that leaves a vertex is met when one goes around it. */
static inline const char *halfedge_check_vertices(const struct dx_halfedges *m)
{
    uint32_t *met = calloc((size_t)m->n + 1, sizeof(*met));
    const char *wrong = NULL;
    uint32_t n = 0;

    for (uint32_t v = 0; v < m->n_vertices; v++) {
        uint32_t h = m->out[v];

        if (h == DX_NO_HALFEDGE)
            continue;
        do {
            if (dx_halfedge_from(m, h) != v || met[h]++) {
                wrong = "what leaves a vertex is of another";
                break;
            }
            n++;
            h = dx_halfedge_around(m, h);
        } while (h != m->out[v]);
    }
    free(met);
    return wrong ? wrong : n == m->n ? NULL : "a vertex does not know all its edges";
}

static inline const char *halfedge_check(const struct dx_halfedges *m)
{
    const char *wrong = halfedge_check_directed(m);

    wrong = wrong ? wrong : halfedge_check_links(m);
    return wrong ? wrong : halfedge_check_vertices(m);
}

static inline struct halfedge_counts halfedge_count(const struct dx_halfedges *m)
{
    struct halfedge_counts c = {0};
    uint8_t *seen = calloc((size_t)m->n + 1, 1);
    uint32_t *corners = calloc((size_t)m->n_vertices + 1, sizeof(*corners));

    for (uint32_t h = 0; h < m->n; h++) {
        uint32_t k = h;

        if (!dx_halfedge_is_border(m, h))
            continue;
        c.n_border++;
        c.n_corners += corners[m->of[h].to]++ > 0;
        c.n_loops += !seen[h];
        for (; !seen[k]; k = m->of[k].next)
            seen[k] = 1;
    }
    for (uint32_t v = 0; v < m->n_vertices; v++)
        c.n_used += m->out[v] != DX_NO_HALFEDGE;
    c.euler = (int64_t)c.n_used - m->n / 2 + m->n_faces;
    free(seen);
    free(corners);
    return c;
}

#endif
