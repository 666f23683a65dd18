/*
 * Follows a stream of dexeld and prints a line for each commit: the least that a subscriber does.
 *   cc follow.c $(pkg-config --cflags --libs libdexel) -o follow
 *   ./follow [STREAM]
 */
#include <dexel.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

/* The mesh is a set of tiles. A viewer would keep their vertices; here their triangles are counted.
 */
struct mesh {
    uint32_t cols, n_tiles;
    uint32_t *n_triangles; /* of each tile */
};

static int on_stream(void *user, const struct dexel_stream *s)
{
    struct mesh *m = user;

    /* Comes before any tile, and again after a reset: start anew. */
    free(m->n_triangles);
    m->cols = s->tile_cols;
    m->n_tiles = s->tile_rows * s->tile_cols;
    m->n_triangles = calloc(m->n_tiles, sizeof(*m->n_triangles));
    if (!m->n_triangles) {
        fprintf(stderr, "follow: no memory for %" PRIu32 " tiles\n", m->n_tiles);
        return 1; /* ends dexel_run() with this value */
    }
    printf("%s: %" PRIu32 " x %" PRIu32 " dexels\n", s->name, s->height, s->width);
    return 0;
}

static int on_tile(void *user, const struct dexel_tile *t)
{
    struct mesh *m = user;

    m->n_triangles[t->row * m->cols + t->col] = t->n_triangles;
    return 0;
}

static int on_commit(void *user, const struct dexel_commit *c)
{
    const struct mesh *m = user;
    uint64_t n = 0;

    for (uint32_t i = 0; i < m->n_tiles; i++)
        n += m->n_triangles[i];
    printf("epoch %" PRIu64 ", frame %" PRIu64 ": %" PRIu32 " tiles changed, %" PRIu64
           " triangles\n",
           c->epoch, c->frame, c->n_tiles, n);
    return 0;
}

/* Of the stream's source; with `reconnect` also "gone" while there is no service, and another one
 * when there is. The mesh that is held stays meanwhile. */
static int on_state(void *user, enum dexel_state state, const char *reason)
{
    static const char *const names[] = {"opening", "live", "stalled", "gone", "ended", "faulted"};

    (void)user;
    printf("%s%s%s\n", names[state], *reason ? ": " : "", reason);
    return 0;
}

int main(int argc, char **argv)
{
    const struct dexel_callbacks callbacks = {
        .stream = on_stream, .tile = on_tile, .commit = on_commit, .state = on_state};
    const struct dexel_options options = {.stream = argc > 1 ? argv[1] : NULL,
                                          .encoding = DEXEL_Q16,
                                          .reconnect = 1}; /* it outlives the service */
    struct mesh mesh = {0};
    struct dexel *d;
    int r;

    setvbuf(stdout, NULL, _IOLBF, 0); /* each line at once, also into a pipe */
    r = dexel_open(&d, &options, &callbacks, &mesh);
    if (r == 0)
        r = dexel_run(d, -1);
    if (r < 0)
        fprintf(stderr, "follow: %s\n", dexel_error(d));
    dexel_close(d);
    free(mesh.n_triangles);
    return r != 0;
}
