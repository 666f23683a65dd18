/* Half-edges: storage and queries. */
#include "core/cloud/halfedge.h"

#include <errno.h>
#include <stdlib.h>

int dx_halfedges_init(struct dx_halfedges *m, uint32_t n_vertices)
{
    *m = (struct dx_halfedges){.n_vertices = n_vertices, .cap_vertices = n_vertices};
    m->out = malloc(((size_t)n_vertices + 1) * sizeof(*m->out));
    if (!m->out)
        return -ENOMEM;
    for (uint32_t v = 0; v < n_vertices; v++)
        m->out[v] = DX_NO_HALFEDGE;
    return 0;
}

void dx_halfedges_fini(struct dx_halfedges *m)
{
    free(m->of);
    free(m->out);
    free(m->face);
    *m = (struct dx_halfedges){0};
}

int dx_halfedges_add_vertex(struct dx_halfedges *m, uint32_t *v)
{
    if (m->n_vertices == m->cap_vertices) {
        const uint32_t cap = m->cap_vertices + m->cap_vertices / 2 + 16;
        uint32_t *out = realloc(m->out, cap * sizeof(*out));

        if (!out)
            return -ENOMEM;
        m->out = out;
        m->cap_vertices = cap;
    }
    *v = m->n_vertices++;
    m->out[*v] = DX_NO_HALFEDGE;
    return 0;
}

uint32_t dx_halfedge_find(const struct dx_halfedges *m, uint32_t u, uint32_t v)
{
    const uint32_t first = m->out[u];
    uint32_t h = first;

    if (first == DX_NO_HALFEDGE)
        return first;
    do {
        if (m->of[h].to == v)
            return h;
        h = dx_halfedge_around(m, h);
    } while (h != first);
    return DX_NO_HALFEDGE;
}

uint32_t dx_halfedge_corner(const struct dx_halfedges *m, uint32_t v)
{
    const uint32_t first = m->out[v];
    uint32_t h = first;

    if (first == DX_NO_HALFEDGE)
        return first;
    do {
        if (dx_halfedge_is_border(m, h))
            return h;
        h = dx_halfedge_around(m, h);
    } while (h != first);
    return DX_NO_HALFEDGE;
}

bool dx_halfedge_fits(const struct dx_halfedges *m, uint32_t b, uint32_t q, uint32_t corner)
{
    const uint32_t u = dx_halfedge_from(m, b), v = m->of[b].to;
    const uint32_t n = m->of[b].next, p = m->of[b].prev;
    const bool at_next = m->of[n].to == q, at_prev = dx_halfedge_from(m, p) == q;

    /* nor the back of the triangle that is there */
    if (!dx_halfedge_is_border(m, b) || q == u || q == v || q == dx_halfedge_apex(m, b ^ 1))
        return false;
    if (m->out[q] == DX_NO_HALFEDGE)
        return true;
    if (at_next && at_prev)
        return m->of[n].next == p;
    if (at_next)
        return dx_halfedge_find(m, u, q) == DX_NO_HALFEDGE;
    if (at_prev)
        return dx_halfedge_find(m, v, q) == DX_NO_HALFEDGE;
    return corner != DX_NO_HALFEDGE && dx_halfedge_from(m, corner) == q &&
           dx_halfedge_is_border(m, corner) && dx_halfedge_find(m, u, q) == DX_NO_HALFEDGE &&
           dx_halfedge_find(m, v, q) == DX_NO_HALFEDGE;
}

bool dx_halfedge_may_flip(const struct dx_halfedges *m, uint32_t h)
{
    const uint32_t t = dx_halfedge_twin(h);
    uint32_t a, b;

    if (dx_halfedge_is_border(m, h) || dx_halfedge_is_border(m, t))
        return false;
    a = dx_halfedge_apex(m, h);
    b = dx_halfedge_apex(m, t);
    return a != b && dx_halfedge_find(m, a, b) == DX_NO_HALFEDGE;
}
