/* The tiles of a mesh: replace, remove, commit, weld. */
#include "tools/mesh_store.h"

#include "core/grid/plane.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* One tile's mesh in one allocation. */
struct held {
    uint32_t n_vertices, n_triangles;
    float *xyz;
    uint32_t *id;
    uint16_t *attr, *index;
};

struct slot {
    struct held *now, *next;
    bool touched; /* since the last commit: `next` (NULL: empty) will replace `now` */
};

struct dx_mesh_store {
    struct dx_tiling tiling;
    uint8_t attr_bytes;
    bool cleared; /* since the last commit */
    uint32_t n_touched;
    uint32_t *touched; /* tile numbers, so that a commit costs what changed */
    uint64_t n_triangles, n_vertices;
    uint32_t n_held;
    struct slot *slots;
};

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
static struct held *hold(const struct dx_store_tile *tile)
{
    size_t n = tile->n_vertices, n_index = 3 * (size_t)tile->n_triangles;
    size_t len = sizeof(struct held) + n * (3 * sizeof(float) + sizeof(uint32_t)) +
                 (n + n_index) * sizeof(uint16_t);
    struct held *h = malloc(len);

    if (!h)
        return NULL;
    h->n_vertices = tile->n_vertices;
    h->n_triangles = tile->n_triangles;
    h->xyz = (float *)(h + 1);
    h->id = (uint32_t *)(h->xyz + 3 * n);
    h->attr = (uint16_t *)(h->id + n);
    h->index = h->attr + n;
    memcpy(h->xyz, tile->xyz, n * 3 * sizeof(float));
    memcpy(h->id, tile->id, n * sizeof(uint32_t));
    if (tile->attr)
        memcpy(h->attr, tile->attr, n * sizeof(uint16_t));
    else
        memset(h->attr, 0, n * sizeof(uint16_t));
    memcpy(h->index, tile->index, n_index * sizeof(uint16_t));
    return h;
}

static void touch(struct dx_mesh_store *s, uint32_t t, struct held *next)
{
    struct slot *slot = &s->slots[t];

    if (!slot->touched)
        s->touched[s->n_touched++] = t;
    slot->touched = true;
    free(slot->next);
    slot->next = next;
}

int dx_mesh_store_set(struct dx_mesh_store *s, const struct dx_store_tile *tile)
{
    struct held *h = NULL;
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
    uint32_t id[DX_TILE_MAX_VERTICES], n = 0;

    if (mesh->row >= s->tiling.rows || mesh->col >= s->tiling.cols)
        return -EBADMSG;
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS && n < mesh->n_vertices; k++)
        if (mesh->mask[k / 8] >> (k % 8) & 1)
            id[n++] = (uint32_t)dx_tile_vertex_id(&s->tiling, mesh->row, mesh->col, k);
    if (n != mesh->n_vertices)
        return -EBADMSG;
    return dx_mesh_store_set(s, &(struct dx_store_tile){
                                    .row = mesh->row,
                                    .col = mesh->col,
                                    .n_vertices = n,
                                    .n_triangles = mesh->n_triangles,
                                    .xyz = mesh->xyz,
                                    .index = mesh->index,
                                    .id = id,
                                    .attr = mesh->attr_bytes ? mesh->attr : NULL,
                                });
}

void dx_mesh_store_reset(struct dx_mesh_store *s)
{
    for (uint32_t k = 0; k < s->n_touched; k++) {
        struct slot *slot = &s->slots[s->touched[k]];

        free(slot->next);
        slot->next = NULL;
        slot->touched = false;
    }
    s->n_touched = 0;
    s->cleared = true;
}

static void replace(struct dx_mesh_store *s, struct slot *slot, struct held *next)
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
    for (uint32_t t = 0; s->cleared && t < dx_tiling_n_tiles(&s->tiling); t++)
        replace(s, &s->slots[t], NULL);
    s->cleared = false;
    for (uint32_t k = 0; k < s->n_touched; k++) {
        struct slot *slot = &s->slots[s->touched[k]];

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

/*
 * Rank of a dexel among the used ones: one bit a dexel, and the count before each word of 64. A few
 * bits a dexel, and the order is that of the ids without sorting.
 */
struct ranks {
    size_t n_words;
    uint64_t *bits;
    uint32_t *before;
};

static int ranks_init(struct ranks *r, size_t n_dexels)
{
    r->n_words = n_dexels / 64 + 1;
    r->bits = calloc(r->n_words, sizeof(*r->bits));
    r->before = malloc(r->n_words * sizeof(*r->before));
    return r->bits && r->before ? 0 : -ENOMEM;
}

static void ranks_fini(struct ranks *r)
{
    free(r->bits);
    free(r->before);
}

static uint32_t rank_of(const struct ranks *r, uint32_t id)
{
    uint64_t below = r->bits[id / 64] & ((UINT64_C(1) << (id % 64)) - 1);

    return r->before[id / 64] + (uint32_t)__builtin_popcountll(below);
}

/* Marks the dexels that triangles use; returns how many. */
static uint32_t ranks_fill(struct ranks *r, const struct dx_mesh_store *s)
{
    uint32_t n = 0;

    for (uint32_t t = 0; t < dx_tiling_n_tiles(&s->tiling); t++) {
        const struct held *h = s->slots[t].now;

        for (uint32_t k = 0; h && k < 3 * h->n_triangles; k++) {
            uint32_t id = h->id[h->index[k]];

            r->bits[id / 64] |= UINT64_C(1) << (id % 64);
        }
    }
    for (size_t w = 0; w < r->n_words; w++) {
        r->before[w] = n;
        n += (uint32_t)__builtin_popcountll(r->bits[w]);
    }
    return n;
}

static void weld_tile(struct dx_mesh *mesh, const struct ranks *r, const struct held *h,
                      uint32_t *index)
{
    for (uint32_t v = 0; v < h->n_vertices; v++) {
        uint32_t id = h->id[v], rank = rank_of(r, id);

        if (!(r->bits[id / 64] >> (id % 64) & 1))
            continue;
        memcpy(mesh->xyz + 3 * (size_t)rank, h->xyz + 3 * (size_t)v, 3 * sizeof(float));
        mesh->id[rank] = id;
        if (mesh->attr)
            mesh->attr[rank] = h->attr[v];
    }
    for (uint32_t k = 0; k < 3 * h->n_triangles; k++)
        index[k] = rank_of(r, h->id[h->index[k]]);
}

int dx_mesh_store_weld(struct dx_mesh *mesh, const struct dx_mesh_store *s)
{
    uint64_t n_triangles = s->n_triangles;
    struct ranks r;
    int rc = ranks_init(&r, (size_t)s->tiling.height * s->tiling.width);

    *mesh = (struct dx_mesh){0};
    if (rc == 0 && n_triangles > DX_MESH_MAX_TRIANGLES)
        rc = -EOVERFLOW;
    if (rc == 0)
        rc = dx_mesh_init(mesh, ranks_fill(&r, s), n_triangles, s->attr_bytes, 1);
    /* From the last tile to the first, so that the first one's word about a vertex stays. */
    for (uint32_t t = dx_tiling_n_tiles(&s->tiling); rc == 0 && t-- > 0;) {
        const struct held *h = s->slots[t].now;

        if (!h)
            continue;
        n_triangles -= h->n_triangles;
        weld_tile(mesh, &r, h, mesh->index + 3 * n_triangles);
    }
    ranks_fini(&r);
    return rc;
}
