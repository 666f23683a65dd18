/* Fans are sets of corners that mates join; each becomes a vertex. */
#include "tools/mesh_repair_priv.h"
#include "tools/union_find.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

struct fans {
    uint32_t *parent; /* [corners] union-find; a fan's root is its lowest corner */
    uint32_t *number; /* [corners] of a root: its vertex */
    uint32_t *from;   /* [n] the vertex that it was */
    uint32_t n;
};

static void join(uint32_t *parent, const uint32_t *mate, uint32_t n_corners)
{
    for (uint32_t c = 0; c < n_corners; c++)
        parent[c] = c;
    for (uint32_t c = 0; c < n_corners; c++)
        if (mate[c] != DX_REPAIR_NONE && mate[c] > c) {
            dx_union_join(parent, c, dx_corner_next(mate[c]));
            dx_union_join(parent, dx_corner_next(c), mate[c]);
        }
}

/* In the order of the vertices they were, then of their lowest corners. */
static int number(struct fans *f, const struct dx_mesh *mesh)
{
    const uint32_t n_corners = 3 * mesh->n_triangles;
    uint32_t *first = calloc((size_t)mesh->n_vertices + 1, sizeof(*first)), sum = 0;

    if (!first)
        return -ENOMEM;
    for (uint32_t c = 0; c < n_corners; c++)
        first[mesh->index[c]] += f->parent[c] == c;
    for (uint32_t v = 0; v < mesh->n_vertices; v++) {
        const uint32_t n = first[v];

        first[v] = sum;
        sum += n;
    }
    f->n = sum;
    f->from = malloc(sum * sizeof(*f->from) + 1);
    for (uint32_t c = 0; f->from && c < n_corners; c++)
        if (f->parent[c] == c) {
            f->number[c] = first[mesh->index[c]]++;
            f->from[f->number[c]] = mesh->index[c];
        }
    free(first);
    return f->from ? 0 : -ENOMEM;
}

/* The array's elements as `from` tells; NULL: there was none. */
static void *chosen(const void *array, const struct fans *f, size_t size)
{
    uint8_t *out = array ? malloc(f->n * size + 1) : NULL;

    for (size_t k = 0; out && k < f->n; k++)
        memcpy(out + k * size, (const uint8_t *)array + f->from[k] * size, size);
    return out;
}

static int move_vertices(struct dx_mesh *mesh, const struct fans *f)
{
    struct dx_mesh to = {.xyz = chosen(mesh->xyz, f, 3 * sizeof(float)),
                         .id = chosen(mesh->id, f, sizeof(uint32_t)),
                         .attr = chosen(mesh->attr, f, sizeof(uint16_t)),
                         .normal = chosen(mesh->normal, f, 3 * sizeof(float))};
    struct dx_mesh from = {
        .xyz = mesh->xyz, .id = mesh->id, .attr = mesh->attr, .normal = mesh->normal};

    if (!to.xyz != !from.xyz || !to.id != !from.id || !to.attr != !from.attr ||
        !to.normal != !from.normal) {
        dx_mesh_fini(&to);
        return -ENOMEM;
    }
    mesh->xyz = to.xyz;
    mesh->id = to.id;
    mesh->attr = to.attr;
    mesh->normal = to.normal;
    mesh->n_vertices = f->n;
    dx_mesh_fini(&from);
    return 0;
}

static uint32_t count_used(const struct fans *f)
{
    uint32_t n = 0;

    for (uint32_t k = 0; k < f->n; k++)
        n += k == 0 || f->from[k] != f->from[k - 1];
    return n;
}

static int split(struct fans *f, struct dx_mesh *mesh, const uint32_t *mate,
                 struct dx_mesh_repair *counts)
{
    const uint32_t n_corners = 3 * mesh->n_triangles;
    int rc;

    join(f->parent, mate, n_corners);
    rc = number(f, mesh);
    if (rc == 0 && f->n > DX_MESH_MAX_VERTICES)
        rc = -EOVERFLOW;
    if (rc == 0)
        rc = move_vertices(mesh, f);
    if (rc < 0)
        return rc;
    for (uint32_t c = 0; c < n_corners; c++)
        mesh->index[c] = f->number[dx_union_root(f->parent, c)];
    counts->split += f->n - count_used(f);
    return 0;
}

int dx_repair_split(struct dx_mesh *mesh, const uint32_t *mate, struct dx_mesh_repair *counts)
{
    const size_t n_corners = 3 * (size_t)mesh->n_triangles;
    struct fans f = {.parent = calloc(n_corners + 1, sizeof(*f.parent)),
                     .number = calloc(n_corners + 1, sizeof(*f.number))};
    int rc = f.parent && f.number ? split(&f, mesh, mate, counts) : -ENOMEM;

    free(f.parent);
    free(f.number);
    free(f.from);
    return rc;
}
