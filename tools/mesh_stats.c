/* Edges by bucketing them under their lower vertex, components by union-find, the digest. */
#include "tools/mesh_stats.h"

#include "core/base/bytes.h"
#include "core/base/hash.h"
#include "tools/union_find.h"

#include <errno.h>
#include <stdlib.h>

/* ---- edges: counting sort by the lower vertex, then each small bucket by the upper one
 * ------------- */

static void edge_of(const uint32_t *triangle, int k, uint32_t *low, uint32_t *key)
{
    uint32_t a = triangle[k], b = triangle[(k + 1) % 3];

    *low = a < b ? a : b;
    *key = (a < b ? b : a) << 1 | (a > b); /* upper vertex, and which way the edge runs */
}

static int compare_keys(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;

    return (x > y) - (x < y);
}

static void sort_keys(uint32_t *keys, size_t n)
{
    if (n > 32) { /* a vertex of many triangles: not from a grid */
        qsort(keys, n, sizeof(*keys), compare_keys);
        return;
    }
    for (size_t i = 1; i < n; i++) {
        uint32_t key = keys[i];
        size_t j = i;

        for (; j > 0 && keys[j - 1] > key; j--)
            keys[j] = keys[j - 1];
        keys[j] = key;
    }
}

static void count_bucket(struct dx_mesh_stats *s, const uint32_t *keys, size_t n)
{
    for (size_t i = 0; i < n;) {
        uint32_t upper = keys[i] >> 1;
        uint64_t runs[2] = {0, 0};

        for (; i < n && keys[i] >> 1 == upper; i++)
            runs[keys[i] & 1]++;
        s->edges++;
        s->boundary_edges += runs[0] + runs[1] == 1;
        s->nonmanifold_edges += runs[0] + runs[1] > 2;
        for (int k = 0; k < 2; k++)
            s->duplicate_directed_edges += runs[k] > 1 ? runs[k] - 1 : 0;
    }
}

static int count_edges(struct dx_mesh_stats *s, const struct dx_mesh *mesh)
{
    size_t n_edges = 3 * (size_t)mesh->n_triangles;
    /* end[v]: first the size of bucket v, then where it starts, at last where it ends. */
    uint32_t *end = calloc((size_t)mesh->n_vertices + 1, sizeof(*end));
    uint32_t *keys = calloc(n_edges + 1, sizeof(*keys));
    uint32_t low, key, sum = 0;
    int rc = end && keys ? 0 : -ENOMEM;

    for (size_t e = 0; rc == 0 && e < n_edges; e++) {
        edge_of(mesh->index + e / 3 * 3, (int)(e % 3), &low, &key);
        end[low]++;
    }
    for (uint32_t v = 0; rc == 0 && v < mesh->n_vertices; v++) {
        uint32_t size = end[v];

        end[v] = sum;
        sum += size;
    }
    for (size_t e = 0; rc == 0 && e < n_edges; e++) {
        edge_of(mesh->index + e / 3 * 3, (int)(e % 3), &low, &key);
        keys[end[low]++] = key;
    }
    for (uint32_t v = 0, start = 0; rc == 0 && v < mesh->n_vertices; start = end[v++]) {
        sort_keys(keys + start, end[v] - start);
        count_bucket(s, keys + start, end[v] - start);
    }
    free(end);
    free(keys);
    return rc;
}

/* ---- components
 * ----------------------------------------------------------------------------------- */

#define UNUSED UINT32_MAX

static int count_components(struct dx_mesh_stats *s, const struct dx_mesh *mesh)
{
    uint32_t *parent = malloc(mesh->n_vertices * sizeof(*parent) + 1);

    if (!parent)
        return -ENOMEM;
    for (uint32_t v = 0; v < mesh->n_vertices; v++)
        parent[v] = UNUSED;
    for (size_t k = 0; k < 3 * (size_t)mesh->n_triangles; k++)
        parent[mesh->index[k]] = mesh->index[k];
    for (size_t t = 0; t < mesh->n_triangles; t++) {
        dx_union_join(parent, mesh->index[3 * t], mesh->index[3 * t + 1]);
        dx_union_join(parent, mesh->index[3 * t], mesh->index[3 * t + 2]);
    }
    for (uint32_t v = 0; v < mesh->n_vertices; v++) {
        s->points += parent[v] != UNUSED;
        s->components += parent[v] == v;
    }
    free(parent);
    return 0;
}

/* ---- digest
 * --------------------------------------------------------------------------------------- */

/* Words are hashed as little-endian bytes, a block at a time. */
struct digest {
    uint64_t hash;
    size_t len;
    uint8_t block[4096];
};

static void digest_flush(struct digest *d)
{
    d->hash = dx_hash(d->hash, d->block, d->len);
    d->len = 0;
}

static void digest_u32(struct digest *d, uint32_t v)
{
    dx_put_u32(d->block + d->len, v);
    d->len += 4;
    if (d->len == sizeof(d->block))
        digest_flush(d);
}

uint64_t dx_mesh_digest(const struct dx_mesh *mesh)
{
    struct digest d = {.hash = 0, .len = 0};

    digest_u32(&d, mesh->n_vertices);
    digest_u32(&d, mesh->n_triangles);
    digest_u32(&d, mesh->attr_bytes);
    for (size_t v = 0; v < mesh->n_vertices; v++) {
        digest_u32(&d, mesh->id ? mesh->id[v] : (uint32_t)v);
        for (int k = 0; k < 3; k++)
            digest_u32(&d, dx_f32_bits(mesh->xyz[3 * v + (size_t)k]));
        if (mesh->attr)
            digest_u32(&d, mesh->attr[v]);
    }
    for (size_t k = 0; k < 3 * (size_t)mesh->n_triangles; k++)
        digest_u32(&d, mesh->index[k]);
    digest_flush(&d);
    return d.hash;
}

int dx_mesh_stats_compute(struct dx_mesh_stats *stats, const struct dx_mesh *mesh)
{
    int rc;

    *stats = (struct dx_mesh_stats){.triangles = mesh->n_triangles};
    rc = count_edges(stats, mesh);
    if (rc == 0)
        rc = count_components(stats, mesh);
    if (rc < 0)
        return rc;
    stats->euler = (int64_t)stats->points - (int64_t)stats->edges + (int64_t)stats->triangles;
    stats->digest = dx_mesh_digest(mesh);
    return 0;
}
