/*
 * From messages to what the application sees: the geometry that q16 and delta need, from its
 * pieces, and the mesh of a tile with the ids and normals of its vertices. One thread at a time.
 */
#include "client/session.h"

#include "core/grid/octahedral.h"

#include <errno.h>

int dx_session_begin_geometry(struct dexel *d)
{
    const struct dx_msg_subscribed *m = &d->told;
    struct dx_geometry *g;
    int r;

    dx_geometry_unref(d->geometry);
    d->geometry = NULL;
    d->geometry_len = 0;
    if (m->table_bytes == 0)
        return 0;
    r = dx_geometry_new(&g, m->model, m->height, m->width);
    if (r < 0)
        return dx_session_fail(d, dx_err_set(&d->err, r, "geometry of %u x %u dexels: %s",
                                             m->height, m->width, strerror(-r)));
    g->wrap = m->wrap;
    g->flip = m->flip;
    g->range_bytes = m->range_bytes;
    g->unit_m = m->unit_m;
    memcpy(g->pose, m->pose, sizeof(g->pose));
    d->geometry = g;
    return 0;
}

int dx_session_add_geometry(struct dexel *d, const struct dx_msg_geometry *piece)
{
    if (piece->total != d->told.table_bytes || piece->offset != d->geometry_len)
        return dx_session_fail(
            d, dx_err_set(&d->err, -EPROTO, "GEOMETRY: bytes from %u of %u, expected from %u of %u",
                          piece->offset, piece->total, d->geometry_len, d->told.table_bytes));
    dx_get_f32s(d->geometry->table + piece->offset / 4, piece->bytes, piece->len / 4);
    d->geometry_len += piece->len;
    return 0;
}

/* Global ids in rank order. */
static void number_vertices(struct dexel *d)
{
    const struct dx_tile_mesh *mesh = &d->mesh;
    uint32_t n = 0;

    for (uint32_t byte = 0; byte < DX_MASK_BYTES; byte++) {
        for (uint32_t bits = mesh->mask[byte]; bits; bits &= bits - 1) {
            const uint32_t k = 8 * byte + (uint32_t)__builtin_ctz(bits);

            d->vertex_id[n++] = (uint32_t)dx_tile_vertex_id(&d->tiling, mesh->row, mesh->col, k);
        }
    }
}

static void spread_normals(struct dexel *d)
{
    for (uint32_t v = 0; v < d->mesh.n_vertices; v++)
        dx_octahedral_decode(d->normal + 3 * (size_t)v, d->mesh.normal + 2 * (size_t)v);
}

static int call_tile(struct dexel *d)
{
    const struct dx_tile_mesh *mesh = &d->mesh;
    const struct dexel_tile tile = {
        .row = mesh->row,
        .col = mesh->col,
        .n_vertices = mesh->n_vertices,
        .n_triangles = mesh->n_triangles,
        .xyz = mesh->xyz,
        .index = mesh->index,
        .dexel = d->vertex_id,
        .attr = mesh->attr_bytes ? mesh->attr : NULL,
        .normal = mesh->has_normals ? d->normal : NULL,
    };

    number_vertices(d);
    if (mesh->has_normals)
        spread_normals(d);
    return d->callbacks.tile(d->user, &tile);
}

static int refuse_chunk(struct dexel *d, const char *what)
{
    return dx_session_fail(
        d, dx_err_set(&d->err, -EPROTO, "message %u, TILE: %s", d->connection.seq_in - 1, what));
}

int dx_session_tile(struct dexel *d, const uint8_t *body, size_t len)
{
    struct dx_chunk_header h;
    int r;

    if (dx_chunk_get_header(&h, body, len, &d->tiling) < 0)
        return refuse_chunk(d, "not a chunk of this grid");
    if (h.encoding != d->told.encoding)
        return refuse_chunk(d, "not in the encoding of the subscription");
    if (h.n_triangles && h.attr_bytes != d->told.attr_bytes)
        return refuse_chunk(d, "not with the attribute of the subscription");
    if (h.n_triangles && h.has_normals != d->told.normals)
        return refuse_chunk(d, "not with the normals of the subscription");
    if (h.n_triangles && h.smoothed != d->told.smooth)
        return refuse_chunk(d, "smoothed where the subscription is not, or the other way round");
    if (d->callbacks.tile && dx_chunk_get(&d->mesh, body, len, &d->tiling, d->geometry) < 0)
        return refuse_chunk(d, "its counts, codes, ranges or indices do not agree");
    r = d->callbacks.raw_tile ? d->callbacks.raw_tile(d->user, body, len) : 0;
    if (r != 0 || !d->callbacks.tile)
        return r;
    return call_tile(d);
}
