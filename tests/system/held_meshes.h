/*
 * Callbacks of libdexel that hold the mesh, and print a line for each commit: its tiles and a
 * CRC-32 of them, which recorded.py tells as well. One thread.
 */
#ifndef DX_HELD_MESHES_H
#define DX_HELD_MESHES_H

#include "core/base/bytes.h"
#include "drivers/file/crc32.h"
#include "tests/system/follower.h"

#define MAX_TILES 64

struct held {
    uint32_t row, col, n_triangles;
    uint8_t *bytes; /* as add_tile puts them; NULL: none */
    size_t len;
};

static struct held held[MAX_TILES];

static void forget(void)
{
    for (unsigned k = 0; k < MAX_TILES; k++)
        free(held[k].bytes);
    memset(held, 0, sizeof(held));
}

static int on_stream(void *user, const struct dexel_stream *s)
{
    (void)user;
    printf("stream %s, model %d, %u x %u\n", s->name, s->model, s->width, s->height);
    return 0;
}

static int on_reset(void *user, const char *reason)
{
    (void)user;
    (void)reason;
    forget();
    puts("reset");
    return 0;
}

static void put_tile(struct dx_writer *w, const struct dexel_tile *t)
{
    const uint32_t n = t->n_vertices;

    dx_write_u32(w, t->row);
    dx_write_u32(w, t->col);
    dx_write_u32(w, n);
    dx_write_u32(w, t->n_triangles);
    dx_put_f32s(dx_write_room(w, 12 * (size_t)n), t->xyz, 3 * (size_t)n);
    dx_put_u16s(dx_write_room(w, 6 * (size_t)t->n_triangles), t->index, 3 * (size_t)t->n_triangles);
    for (uint32_t v = 0; v < n; v++)
        dx_write_u32(w, t->dexel[v]);
    if (t->attr)
        dx_put_u16s(dx_write_room(w, 2 * (size_t)n), t->attr, n);
    if (t->normal)
        dx_put_f32s(dx_write_room(w, 12 * (size_t)n), t->normal, 3 * (size_t)n);
}

/* The tile's place among those held, which are in the order of rows and columns. */
static int on_tile(void *user, const struct dexel_tile *t)
{
    const size_t room = 16 + 30 * (size_t)t->n_vertices + 6 * (size_t)t->n_triangles;
    struct held *h = held;
    struct dx_writer w;

    (void)user;
    while (h < held + MAX_TILES && h->bytes && (h->row != t->row || h->col != t->col))
        h++;
    if (h == held + MAX_TILES)
        die("more than %d tiles", MAX_TILES);
    free(h->bytes);
    *h = (struct held){t->row, t->col, t->n_triangles, malloc(room), 0};
    if (!h->bytes)
        die("no memory");
    w = dx_writer_init(h->bytes, room);
    if (t->n_triangles)
        put_tile(&w, t);
    h->len = (size_t)(w.p - h->bytes);
    return 0;
}

static int compare(const void *a, const void *b)
{
    const struct held *x = a, *y = b;
    const uint64_t kx = (uint64_t)x->row << 32 | x->col, ky = (uint64_t)y->row << 32 | y->col;

    if (!x->bytes || !y->bytes)
        return !x->bytes - !y->bytes;
    return (kx > ky) - (kx < ky);
}

static int on_commit(void *user, const struct dexel_commit *c)
{
    unsigned n_tiles = 0, n_triangles = 0;
    uint32_t crc = 0;

    (void)user;
    qsort(held, MAX_TILES, sizeof(held[0]), compare);
    for (const struct held *h = held; h < held + MAX_TILES && h->bytes; h++) {
        crc = dx_crc32(crc, h->bytes, h->len);
        n_tiles += h->n_triangles > 0;
        n_triangles += h->n_triangles;
    }
    printf("commit %llu, frame %llu, caps %d %d: %u tiles, %u triangles, %08x\n",
           (unsigned long long)c->epoch, (unsigned long long)c->frame, c->cap_first, c->cap_last,
           n_tiles, n_triangles, crc);
    return 0;
}

static int on_state(void *user, enum dexel_state state, const char *reason)
{
    (void)user;
    (void)reason;
    if (state == DEXEL_ENDED)
        puts("ended");
    return 0;
}

static const struct dexel_callbacks callbacks = {
    .stream = on_stream,
    .reset = on_reset,
    .tile = on_tile,
    .commit = on_commit,
    .state = on_state,
};

#endif
