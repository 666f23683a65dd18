/* The tiles of a store as one mesh: vertices by id, the caps after the tiles. One thread. */
#include "tools/mesh_store_priv.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

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
        const struct dx_held *h = s->slots[t].now;

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

static void weld_tile(struct dx_mesh *mesh, const struct ranks *r, const struct dx_held *h,
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
        if (mesh->normal)
            memcpy(mesh->normal + 3 * (size_t)rank, h->normal + 3 * (size_t)v, 3 * sizeof(float));
    }
    for (uint32_t k = 0; k < 3 * h->n_triangles; k++)
        index[k] = rank_of(r, h->id[h->index[k]]);
}

/* ---- caps ----------------------------------------------------------------------------------- */

/* Whether every dexel of a row is a vertex. */
static bool is_whole_row(const struct ranks *r, const struct dx_tiling *t, uint32_t row)
{
    for (uint32_t j = 0; j < t->width; j++) {
        uint32_t id = row * t->width + j;

        if (!(r->bits[id / 64] >> (id % 64) & 1))
            return false;
    }
    return true;
}

/* The fan over a row whose ranks go up from `first` one by one. Backwards: (0, j + 1, j). */
static uint32_t *put_fan(uint32_t *index, uint32_t first, uint32_t width, bool backwards)
{
    for (uint32_t j = 1; j + 1 < width; j++) {
        *index++ = first;
        *index++ = first + j + backwards;
        *index++ = first + j + !backwards;
    }
    return index;
}

static void weld_caps(uint32_t *index, const struct ranks *r, const struct dx_mesh_store *s,
                      bool first, bool last)
{
    const struct dx_tiling *t = &s->tiling;

    if (first)
        index = put_fan(index, rank_of(r, 0), t->width, !s->caps.flip);
    if (last)
        put_fan(index, rank_of(r, (t->height - 1) * t->width), t->width, s->caps.flip);
}

/* ---- weld ----------------------------------------------------------------------------------- */

static bool all_have_normals(const struct dx_mesh_store *s)
{
    for (uint32_t t = 0; t < dx_tiling_n_tiles(&s->tiling); t++)
        if (s->slots[t].now && !s->slots[t].now->has_normals)
            return false;
    return s->n_held > 0;
}

int dx_mesh_store_weld(struct dx_mesh *mesh, const struct dx_mesh_store *s)
{
    uint64_t n_triangles = s->n_triangles, n_fan = s->tiling.width < 3 ? 0 : s->tiling.width - 2;
    bool first = false, last = false;
    struct ranks r;
    int rc = ranks_init(&r, (size_t)s->tiling.height * s->tiling.width);
    uint32_t n_vertices;

    *mesh = (struct dx_mesh){0};
    if (rc == 0 && n_triangles + 2 * n_fan > DX_MESH_MAX_TRIANGLES)
        rc = -EOVERFLOW;
    if (rc == 0) {
        n_vertices = ranks_fill(&r, s);
        first = s->caps.first && is_whole_row(&r, &s->tiling, 0);
        last = s->caps.last && is_whole_row(&r, &s->tiling, s->tiling.height - 1);
        rc = dx_mesh_init(mesh, n_vertices, n_triangles + (first + last) * n_fan, s->attr_bytes, 1);
    }
    if (rc == 0 && all_have_normals(s))
        rc = dx_mesh_add_normals(mesh);
    if (rc == 0)
        weld_caps(mesh->index + 3 * n_triangles, &r, s, first, last);
    /* From the last tile to the first, so that the first one's word about a vertex stays. */
    for (uint32_t t = dx_tiling_n_tiles(&s->tiling); rc == 0 && t-- > 0;) {
        const struct dx_held *h = s->slots[t].now;

        if (!h)
            continue;
        n_triangles -= h->n_triangles;
        weld_tile(mesh, &r, h, mesh->index + 3 * n_triangles);
    }
    ranks_fini(&r);
    return rc;
}
