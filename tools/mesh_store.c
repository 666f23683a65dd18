/* The tiles of a mesh: replace, remove, commit. */
#include "tools/mesh_store_priv.h"

#include "core/grid/octahedral.h"
#include "core/grid/plane.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

int dx_mesh_store_new(struct dx_mesh_store **out, uint32_t height, uint32_t width, bool wrap,
                      uint8_t attr_bytes)
{
    struct dx_mesh_store *s;
    uint32_t n;

    *out = NULL;
    if (height < 1 || width < 1 || height > DX_PLANE_MAX_SIDE || width > DX_PLANE_MAX_SIDE ||
        (uint64_t)height * width > DX_PLANE_MAX_DEXELS || attr_bytes > 2)
        return -EINVAL;
    s = calloc(1, sizeof(*s));
    if (!s)
        return -ENOMEM;
    dx_tiling_init(&s->tiling, height, width, wrap);
    s->attr_bytes = attr_bytes;
    n = dx_tiling_n_tiles(&s->tiling);
    s->slots = calloc((size_t)n + 1, sizeof(*s->slots));
    s->touched = calloc((size_t)n + 1, sizeof(*s->touched));
    if (!s->slots || !s->touched) {
        dx_mesh_store_free(s);
        return -ENOMEM;
    }
    *out = s;
    return 0;
}

void dx_mesh_store_free(struct dx_mesh_store *s)
{
    if (!s)
        return;
    for (uint32_t t = 0; s->slots && t < dx_tiling_n_tiles(&s->tiling); t++) {
        free(s->slots[t].now);
        free(s->slots[t].next);
    }
    free(s->slots);
    free(s->touched);
    free(s);
}

static int check_tile(const struct dx_mesh_store *s, const struct dx_store_tile *tile)
{
    uint64_t n_dexels = (uint64_t)s->tiling.height * s->tiling.width;

    if (tile->row >= s->tiling.rows || tile->col >= s->tiling.cols ||
        tile->n_vertices > DX_TILE_MAX_VERTICES || tile->n_triangles > DX_TILE_MAX_TRIANGLES)
        return -EBADMSG;
    for (uint32_t v = 0; v < tile->n_vertices; v++)
        if (tile->id[v] >= n_dexels)
            return -EBADMSG;
    for (uint32_t k = 0; k < 3 * tile->n_triangles; k++)
        if (tile->index[k] >= tile->n_vertices)
            return -EBADMSG;
    return 0;
}

/* The counts are bounded by check_tile, so the sum fits easily. */
static struct dx_held *hold(const struct dx_store_tile *tile)
{
    size_t n = tile->n_vertices, n_index = 3 * (size_t)tile->n_triangles;
    size_t n_normal = tile->normal ? 3 * n : 0;
    size_t len = sizeof(struct dx_held) + (3 * n + n_normal) * sizeof(float) +
                 n * sizeof(uint32_t) + (n + n_index) * sizeof(uint16_t);
    struct dx_held *h = malloc(len);

    if (!h)
        return NULL;
    h->n_vertices = tile->n_vertices;
    h->n_triangles = tile->n_triangles;
    h->has_normals = tile->normal != NULL;
    h->xyz = (float *)(h + 1);
    h->normal = h->xyz + 3 * n;
    h->id = (uint32_t *)(h->normal + n_normal);
    h->attr = (uint16_t *)(h->id + n);
    h->index = h->attr + n;
    memcpy(h->xyz, tile->xyz, n * 3 * sizeof(float));
    if (tile->normal)
        memcpy(h->normal, tile->normal, n_normal * sizeof(float));
    memcpy(h->id, tile->id, n * sizeof(uint32_t));
    if (tile->attr)
        memcpy(h->attr, tile->attr, n * sizeof(uint16_t));
    else
        memset(h->attr, 0, n * sizeof(uint16_t));
    memcpy(h->index, tile->index, n_index * sizeof(uint16_t));
    return h;
}

static void touch(struct dx_mesh_store *s, uint32_t t, struct dx_held *next)
{
    struct dx_store_slot *slot = &s->slots[t];

    if (!slot->touched)
        s->touched[s->n_touched++] = t;
    slot->touched = true;
    free(slot->next);
    slot->next = next;
}

int dx_mesh_store_set(struct dx_mesh_store *s, const struct dx_store_tile *tile)
{
    struct dx_held *h = NULL;
    int rc = check_tile(s, tile);

    if (rc < 0)
        return rc;
    if (tile->n_triangles) {
        h = hold(tile);
        if (!h)
            return -ENOMEM;
    }
    touch(s, tile->row * s->tiling.cols + tile->col, h);
    return 0;
}

int dx_mesh_store_set_mesh(struct dx_mesh_store *s, const struct dx_tile_mesh *mesh)
{
    float normal[3 * DX_TILE_MAX_VERTICES];
    uint32_t id[DX_TILE_MAX_VERTICES], n = 0;

    if (mesh->row >= s->tiling.rows || mesh->col >= s->tiling.cols)
        return -EBADMSG;
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS && n < mesh->n_vertices; k++)
        if (mesh->mask[k / 8] >> (k % 8) & 1)
            id[n++] = (uint32_t)dx_tile_vertex_id(&s->tiling, mesh->row, mesh->col, k);
    if (n != mesh->n_vertices)
        return -EBADMSG;
    for (uint32_t v = 0; mesh->has_normals && v < n; v++)
        dx_octahedral_decode(normal + 3 * (size_t)v, mesh->normal + 2 * (size_t)v);
    return dx_mesh_store_set(s, &(struct dx_store_tile){
                                    .row = mesh->row,
                                    .col = mesh->col,
                                    .n_vertices = n,
                                    .n_triangles = mesh->n_triangles,
                                    .xyz = mesh->xyz,
                                    .index = mesh->index,
                                    .id = id,
                                    .attr = mesh->attr_bytes ? mesh->attr : NULL,
                                    .normal = mesh->has_normals ? normal : NULL,
                                });
}

void dx_mesh_store_reset(struct dx_mesh_store *s)
{
    for (uint32_t k = 0; k < s->n_touched; k++) {
        struct dx_store_slot *slot = &s->slots[s->touched[k]];

        free(slot->next);
        slot->next = NULL;
        slot->touched = false;
    }
    s->n_touched = 0;
    s->cleared = true;
    s->next_caps = (struct dx_store_caps){0};
}

void dx_mesh_store_set_caps(struct dx_mesh_store *s, bool first, bool last, bool flip)
{
    s->next_caps = (struct dx_store_caps){first, last, flip};
}

static void replace(struct dx_mesh_store *s, struct dx_store_slot *slot, struct dx_held *next)
{
    if (slot->now) {
        s->n_triangles -= slot->now->n_triangles;
        s->n_vertices -= slot->now->n_vertices;
        s->n_held--;
        free(slot->now);
    }
    slot->now = next;
    if (next) {
        s->n_triangles += next->n_triangles;
        s->n_vertices += next->n_vertices;
        s->n_held++;
    }
}

void dx_mesh_store_commit(struct dx_mesh_store *s)
{
    s->caps = s->next_caps;
    for (uint32_t t = 0; s->cleared && t < dx_tiling_n_tiles(&s->tiling); t++)
        replace(s, &s->slots[t], NULL);
    s->cleared = false;
    for (uint32_t k = 0; k < s->n_touched; k++) {
        struct dx_store_slot *slot = &s->slots[s->touched[k]];

        replace(s, slot, slot->next);
        slot->next = NULL;
        slot->touched = false;
    }
    s->n_touched = 0;
}

uint64_t dx_mesh_store_n_triangles(const struct dx_mesh_store *s)
{
    return s->n_triangles;
}

uint64_t dx_mesh_store_n_tile_vertices(const struct dx_mesh_store *s)
{
    return s->n_vertices;
}

uint32_t dx_mesh_store_n_tiles(const struct dx_mesh_store *s)
{
    return s->n_held;
}
