/*
 * mesh_digests SOCKET live|lossless [N]: a subscriber that prints, of each whole frame, its number
 * and the digest of its mesh, "12 0123456789abcdef"; N of them, or until the stream ends.
 */
#include "client/dexel.h"
#include "tools/mesh_stats.h"
#include "tools/mesh_store.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SILENCE_MS 60000
#define DONE       1
#define FAILED     2

static struct {
    struct dx_mesh_store *mesh;
    int flip;
    unsigned long n_wanted, n; /* 0: all */
} got;

static int on_stream(void *user, const struct dexel_stream *s)
{
    (void)user;
    dx_mesh_store_free(got.mesh);
    got.mesh = NULL;
    got.flip = s->flip;
    return dx_mesh_store_new(&got.mesh, s->height, s->width, s->wrap, (uint8_t)s->attr_bytes) < 0
               ? FAILED
               : 0;
}

static int on_tile(void *user, const struct dexel_tile *t)
{
    const struct dx_store_tile tile = {.row = t->row,
                                       .col = t->col,
                                       .n_vertices = t->n_vertices,
                                       .n_triangles = t->n_triangles,
                                       .xyz = t->xyz,
                                       .index = t->index,
                                       .id = t->dexel,
                                       .attr = t->attr,
                                       .normal = t->normal};

    (void)user;
    return dx_mesh_store_set(got.mesh, &tile) < 0 ? FAILED : 0;
}

static int on_commit(void *user, const struct dexel_commit *c)
{
    struct dx_mesh mesh;
    int r;

    (void)user;
    dx_mesh_store_set_caps(got.mesh, c->cap_first, c->cap_last, got.flip);
    dx_mesh_store_commit(got.mesh);
    if (c->partial)
        return 0;
    r = dx_mesh_store_weld(&mesh, got.mesh);
    if (r == 0)
        printf("%" PRIu64 " %016" PRIx64 "\n", c->frame, dx_mesh_digest(&mesh));
    dx_mesh_fini(&mesh);
    if (r < 0)
        return FAILED;
    return ++got.n == got.n_wanted ? DONE : 0;
}

static int on_state(void *user, enum dexel_state state, const char *reason)
{
    (void)user, (void)reason;
    return state == DEXEL_ENDED ? DONE : 0;
}

int main(int argc, char **argv)
{
    static const struct dexel_callbacks callbacks = {
        .stream = on_stream, .tile = on_tile, .commit = on_commit, .state = on_state};
    struct dexel_options options = {.encoding = DEXEL_F32};
    struct dexel *d;
    int r;

    if (argc != 3 && argc != 4) {
        fprintf(stderr, "usage: mesh_digests SOCKET live|lossless [N]\n");
        return 2;
    }
    options.socket = argv[1];
    options.mode = strcmp(argv[2], "lossless") == 0 ? DEXEL_LOSSLESS : DEXEL_LIVE;
    got.n_wanted = argc == 4 ? strtoul(argv[3], NULL, 10) : 0;
    r = dexel_open(&d, &options, &callbacks, NULL);
    if (r == 0)
        r = dexel_run(d, SILENCE_MS);
    if (r < 0)
        fprintf(stderr, "mesh_digests: %s\n", dexel_error(d));
    dexel_close(d);
    dx_mesh_store_free(got.mesh);
    return r != DONE;
}
