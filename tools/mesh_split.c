/* Corners of triangles joined into fans over the edges that two triangles share. */
#include "tools/mesh_split.h"

#include "tools/union_find.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX

/* Corner c is vertex index[c] in triangle c / 3; corners by vertex, those of v from first[v] on. */
struct fans {
    const struct dx_mesh *mesh;
    uint32_t n_corners;
    uint32_t *first;    /* [n_vertices + 1] */
    uint32_t *corner;   /* [n_corners] */
    uint32_t *parent;   /* [n_corners] union-find; a fan's root is its lowest corner */
    uint32_t *vertex;   /* [n_corners] of a root: the vertex of its fan */
    uint32_t *original; /* [n_added] what a new vertex was */
};

static uint32_t next_in_triangle(uint32_t c)
{
    return c % 3 == 2 ? c - 2 : c + 1;
}

static void fans_fini(struct fans *f)
{
    free(f->first);
    free(f->corner);
    free(f->parent);
    free(f->vertex);
    free(f->original);
}

static int fans_init(struct fans *f, const struct dx_mesh *mesh)
{
    const size_t n = 3 * (size_t)mesh->n_triangles;

    *f = (struct fans){.mesh = mesh, .n_corners = (uint32_t)n};
    f->first = calloc((size_t)mesh->n_vertices + 2, sizeof(*f->first));
    f->corner = malloc(n * sizeof(*f->corner) + 1);
    f->parent = malloc(n * sizeof(*f->parent) + 1);
    f->vertex = malloc(n * sizeof(*f->vertex) + 1);
    if (!f->first || !f->corner || !f->parent || !f->vertex)
        return -ENOMEM;
    /* counting sort: first[v + 1] runs through the corners of v and ends where v + 1 begins */
    for (size_t c = 0; c < n; c++)
        f->first[mesh->index[c] + 2]++;
    for (size_t v = 2; v <= (size_t)mesh->n_vertices + 1; v++)
        f->first[v] += f->first[v - 1];
    for (uint32_t c = 0; c < n; c++) {
        f->corner[f->first[mesh->index[c] + 1]++] = c;
        f->parent[c] = c;
        f->vertex[c] = NONE;
    }
    return 0;
}

/* The corner from which the edge a -> b starts, or NONE. */
static uint32_t find_edge(const struct fans *f, uint32_t a, uint32_t b)
{
    for (uint32_t k = f->first[a]; k < f->first[a + 1]; k++)
        if (f->mesh->index[next_in_triangle(f->corner[k])] == b)
            return f->corner[k];
    return NONE;
}

static void join_fans(struct fans *f)
{
    const uint32_t *index = f->mesh->index;

    for (uint32_t c = 0; c < f->n_corners; c++) {
        uint32_t n = next_in_triangle(c), back;

        if (index[c] > index[n]) /* each shared edge from its lower end */
            continue;
        back = find_edge(f, index[n], index[c]);
        if (back == NONE)
            continue;
        dx_union_join(f->parent, n, back);
        dx_union_join(f->parent, c, next_in_triangle(back));
    }
}

/* A vertex for each fan: the old one for the first, a new one for each other; how many are new. */
static int number_fans(struct fans *f, uint32_t *n_added)
{
    const uint32_t n = f->mesh->n_vertices;
    uint32_t room = 0;

    for (uint32_t v = 0; v < n; v++)
        for (uint32_t k = f->first[v]; k < f->first[v + 1]; k++) {
            uint32_t root = dx_union_root(f->parent, f->corner[k]);

            if (f->vertex[root] != NONE)
                continue;
            if (k == f->first[v]) {
                f->vertex[root] = v;
                continue;
            }
            if (*n_added == room) {
                uint32_t *grown = realloc(f->original, (room = 2 * room + 16) * sizeof(*grown));

                if (!grown)
                    return -ENOMEM;
                f->original = grown;
            }
            if (n + *n_added >= DX_MESH_MAX_VERTICES - 1)
                return -EOVERFLOW;
            f->vertex[root] = n + *n_added;
            f->original[(*n_added)++] = v;
        }
    return 0;
}

/* The array with `n_added` elements of `size` bytes more, copies of those they were; NULL: no
 * memory, and the array is as it was. */
static void *extended(void *array, const struct fans *f, uint32_t n_added, size_t size)
{
    const size_t n = f->mesh->n_vertices;
    uint8_t *grown = realloc(array, (n + n_added) * size + 1);

    for (uint32_t k = 0; grown && k < n_added; k++)
        memcpy(grown + (n + k) * size, grown + f->original[k] * size, size);
    return grown;
}

static int extend_vertices(struct dx_mesh *mesh, const struct fans *f, uint32_t n_added)
{
    float *xyz = extended(mesh->xyz, f, n_added, 3 * sizeof(float));
    uint32_t *id = mesh->id ? extended(mesh->id, f, n_added, sizeof(uint32_t)) : NULL;
    uint16_t *attr = mesh->attr ? extended(mesh->attr, f, n_added, sizeof(uint16_t)) : NULL;
    float *normal = mesh->normal ? extended(mesh->normal, f, n_added, 3 * sizeof(float)) : NULL;
    bool whole = xyz && (id || !mesh->id) && (attr || !mesh->attr) && (normal || !mesh->normal);

    mesh->xyz = xyz ? xyz : mesh->xyz;
    mesh->id = id ? id : mesh->id;
    mesh->attr = attr ? attr : mesh->attr;
    mesh->normal = normal ? normal : mesh->normal;
    return whole ? 0 : -ENOMEM;
}

/* (p1 - p0) x (p2 - p0) of a triangle, added to what its split corners have. */
static void add_normal(struct dx_mesh *mesh, const uint8_t *is_split, const uint32_t *corner)
{
    const float *p[3];
    float u[3], v[3], n[3];

    for (int k = 0; k < 3; k++)
        p[k] = mesh->xyz + 3 * (size_t)corner[k];
    for (int k = 0; k < 3; k++) {
        u[k] = p[1][k] - p[0][k];
        v[k] = p[2][k] - p[0][k];
    }
    n[0] = u[1] * v[2] - u[2] * v[1];
    n[1] = u[2] * v[0] - u[0] * v[2];
    n[2] = u[0] * v[1] - u[1] * v[0];
    for (int m = 0; m < 3; m++)
        for (int k = 0; is_split[corner[m]] && k < 3; k++)
            mesh->normal[3 * (size_t)corner[m] + (size_t)k] += n[k];
}

/* What was one vertex had the normal of all its fans: each gets that of its own. */
static int split_normals(struct dx_mesh *mesh, const struct fans *f, uint32_t n_added)
{
    uint8_t *is_split = calloc((size_t)mesh->n_vertices + 1, 1);

    if (!is_split)
        return -ENOMEM;
    for (uint32_t k = 0; k < n_added; k++)
        is_split[f->original[k]] = is_split[mesh->n_vertices - n_added + k] = 1;
    for (size_t v = 0; v < mesh->n_vertices; v++)
        if (is_split[v])
            memset(mesh->normal + 3 * v, 0, 3 * sizeof(*mesh->normal));
    for (size_t t = 0; t < mesh->n_triangles; t++)
        add_normal(mesh, is_split, mesh->index + 3 * t);
    for (size_t v = 0; v < mesh->n_vertices; v++) {
        float *n = mesh->normal + 3 * v, length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);

        for (int k = 0; is_split[v] && length > 0 && k < 3; k++)
            n[k] /= length;
    }
    free(is_split);
    return 0;
}

static int split(struct dx_mesh *mesh, struct fans *f, uint32_t *n_added)
{
    int rc;

    join_fans(f);
    rc = number_fans(f, n_added);
    if (rc == 0)
        rc = extend_vertices(mesh, f, *n_added);
    if (rc < 0)
        return rc;
    for (uint32_t c = 0; c < f->n_corners; c++)
        mesh->index[c] = f->vertex[dx_union_root(f->parent, c)];
    mesh->n_vertices += *n_added;
    return mesh->normal && *n_added ? split_normals(mesh, f, *n_added) : 0;
}

int64_t dx_mesh_split(struct dx_mesh *mesh)
{
    uint32_t n_added = 0;
    struct fans f;
    int rc = fans_init(&f, mesh);

    if (rc == 0)
        rc = split(mesh, &f, &n_added);
    fans_fini(&f);
    return rc < 0 ? rc : (int64_t)n_added;
}
