/* Half-edges: operations. Room is made first, so that one that fails has changed nothing. */
#include "core/cloud/halfedge.h"

#include <errno.h>
#include <stdlib.h>

static int reserve(struct dx_halfedges *m, uint32_t n_edges, uint32_t n_faces)
{
    if (m->n + 2 * n_edges > m->cap) {
        const uint32_t cap = m->cap + m->cap / 2 + 64;
        struct dx_halfedge *of = realloc(m->of, cap * sizeof(*of));

        if (!of)
            return -ENOMEM;
        m->of = of;
        m->cap = cap;
    }
    if (m->n_faces + n_faces > m->cap_faces) {
        const uint32_t cap = m->cap_faces + m->cap_faces / 2 + 64;
        uint32_t *face = realloc(m->face, cap * sizeof(*face));

        if (!face)
            return -ENOMEM;
        m->face = face;
        m->cap_faces = cap;
    }
    return 0;
}

/* An edge from u to v, a border on both sides; returns that direction. */
static uint32_t new_edge(struct dx_halfedges *m, uint32_t u, uint32_t v)
{
    const uint32_t h = m->n;

    m->n += 2;
    m->of[h] = (struct dx_halfedge){v, DX_NO_HALFEDGE, DX_NO_HALFEDGE, DX_NO_HALFEDGE};
    m->of[h + 1] = (struct dx_halfedge){u, DX_NO_HALFEDGE, DX_NO_HALFEDGE, DX_NO_HALFEDGE};
    return h;
}

static void join(struct dx_halfedges *m, uint32_t h, uint32_t next)
{
    m->of[h].next = next;
    m->of[next].prev = h;
}

static void make_face(struct dx_halfedges *m, uint32_t f, uint32_t a, uint32_t b, uint32_t c)
{
    join(m, a, b);
    join(m, b, c);
    join(m, c, a);
    m->of[a].face = m->of[b].face = m->of[c].face = f;
    m->face[f] = a;
}

int dx_halfedges_add_triangle(struct dx_halfedges *m, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t ab, bc, ca;

    if (reserve(m, 3, 1) < 0)
        return -ENOMEM;
    ab = new_edge(m, a, b);
    bc = new_edge(m, b, c);
    ca = new_edge(m, c, a);
    make_face(m, m->n_faces++, ab, bc, ca);
    join(m, ab ^ 1, ca ^ 1);
    join(m, ca ^ 1, bc ^ 1);
    join(m, bc ^ 1, ab ^ 1);
    m->out[a] = ab;
    m->out[b] = bc;
    m->out[c] = ca;
    return 0;
}

int dx_halfedges_glue(struct dx_halfedges *m, uint32_t b, uint32_t q, uint32_t corner)
{
    const uint32_t u = dx_halfedge_from(m, b), v = m->of[b].to;
    const uint32_t n = m->of[b].next, p = m->of[b].prev;
    const bool at_next = m->of[n].to == q, at_prev = dx_halfedge_from(m, p) == q;
    const uint32_t after = m->of[n].next, before = m->of[p].prev;
    uint32_t to_q, from_q;

    if (reserve(m, 2, 1) < 0)
        return -ENOMEM;
    to_q = at_next ? n : new_edge(m, v, q);
    from_q = at_prev ? p : new_edge(m, q, u);
    if (at_next && !at_prev) {
        join(m, p, from_q ^ 1);
        join(m, from_q ^ 1, after);
    } else if (at_prev && !at_next) {
        join(m, before, to_q ^ 1);
        join(m, to_q ^ 1, n);
    } else if (!at_next) {
        const bool is_new = m->out[q] == DX_NO_HALFEDGE;
        const uint32_t into = is_new ? from_q ^ 1 : m->of[corner].prev;

        if (!is_new)
            join(m, from_q ^ 1, corner);
        join(m, p, from_q ^ 1);
        join(m, into, to_q ^ 1);
        join(m, to_q ^ 1, n);
        m->out[q] = from_q;
    }
    make_face(m, m->n_faces++, b, to_q, from_q);
    return 0;
}

/* Triangle x y z w, of four half-edges since x and y meet in the new vertex, becomes (x, d, w) and
 * (y, z, d back). */
static void split_side(struct dx_halfedges *m, uint32_t x, uint32_t y)
{
    const uint32_t z = m->of[y].next, w = m->of[z].next, f = m->of[x].face;
    uint32_t d;

    if (f == DX_NO_HALFEDGE)
        return;
    d = new_edge(m, m->of[x].to, m->of[z].to);
    make_face(m, f, x, d, w);
    make_face(m, m->n_faces++, y, z, d ^ 1);
}

int dx_halfedges_split_edge(struct dx_halfedges *m, uint32_t h, uint32_t v)
{
    const uint32_t t = h ^ 1, end = m->of[h].to;
    uint32_t e;

    if (reserve(m, 3, 2) < 0)
        return -ENOMEM;
    e = new_edge(m, v, end);
    m->of[h].to = v;
    m->of[e].face = m->of[h].face;
    m->of[e ^ 1].face = m->of[t].face;
    join(m, e, m->of[h].next);
    join(m, h, e);
    join(m, m->of[t].prev, e ^ 1);
    join(m, e ^ 1, t);
    if (m->out[end] == t)
        m->out[end] = e ^ 1;
    m->out[v] = e;
    split_side(m, h, e);
    split_side(m, e ^ 1, t);
    return 0;
}

void dx_halfedges_flip(struct dx_halfedges *m, uint32_t h)
{
    const uint32_t t = h ^ 1, u = m->of[t].to, v = m->of[h].to;
    const uint32_t n1 = m->of[h].next, p1 = m->of[h].prev, n2 = m->of[t].next, p2 = m->of[t].prev;
    const uint32_t a = m->of[n1].to, b = m->of[n2].to;

    m->of[h].to = a;
    m->of[t].to = b;
    if (m->out[u] == h)
        m->out[u] = n2;
    if (m->out[v] == t)
        m->out[v] = n1;
    make_face(m, m->of[h].face, h, p1, n2);
    make_face(m, m->of[t].face, t, p2, n1);
}

/* The fan that begins with border half-edge h gets vertex `made`; ends where a border comes in. */
static void part_fan(struct dx_halfedges *m, uint32_t h, uint32_t made)
{
    uint32_t k = h;

    m->out[made] = h;
    for (;;) {
        m->of[k ^ 1].to = made;
        if (dx_halfedge_is_border(m, k ^ 1))
            break;
        k = m->of[k ^ 1].next;
    }
    join(m, k ^ 1, h);
}

/* Where the fan of border half-edge h, which leaves its vertex, ends: the border that comes in. */
static uint32_t end_of_fan(const struct dx_halfedges *m, uint32_t h)
{
    while (!dx_halfedge_is_border(m, h ^ 1))
        h = m->of[h ^ 1].next;
    return h ^ 1;
}

/* Fans beyond the one of `first` leave v, which is v's only corner then. */
static int split_fans_of(struct dx_halfedges *m, uint32_t v, uint32_t first,
                         int (*copied)(void *ctx, uint32_t old, uint32_t made), void *ctx)
{
    /* its border comes in, and goes on to the next fan */
    const uint32_t into = end_of_fan(m, first);

    while (m->of[into].next != first) {
        const uint32_t h = m->of[into].next, after = m->of[end_of_fan(m, h)].next;
        uint32_t made;
        int rc = dx_halfedges_add_vertex(m, &made);

        if (rc < 0)
            return rc;
        join(m, into, after);
        part_fan(m, h, made);
        rc = copied(ctx, v, made);
        if (rc < 0)
            return rc;
    }
    m->out[v] = first;
    return 0;
}

int dx_halfedges_split_fans(struct dx_halfedges *m,
                            int (*copied)(void *ctx, uint32_t old, uint32_t made), void *ctx)
{
    const uint32_t n = m->n_vertices;
    int rc = 0;

    for (uint32_t v = 0; v < n && rc == 0; v++) {
        const uint32_t corner = dx_halfedge_corner(m, v);

        if (corner != DX_NO_HALFEDGE)
            rc = split_fans_of(m, v, corner, copied, ctx);
    }
    return rc;
}
