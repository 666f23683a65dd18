/*
 * Tiles and messages for the tests of the wire and of libdexel: random tiles under a real geometry,
 * and the bytes a server would say. Test code only; one thread.
 */
#ifndef DX_TILE_FIXTURE_H
#define DX_TILE_FIXTURE_H

#include <assert.h>
#include <stdlib.h>

#include "core/base/rng.h"
#include "core/wire/chunk.h"

/* Cells of a tile in one direction. */
static inline uint8_t fixture_cells(uint32_t cells, uint32_t tile)
{
    uint32_t left = cells - tile * DX_TILE_CELLS;

    return (uint8_t)(left < DX_TILE_CELLS ? left : DX_TILE_CELLS);
}

/* Whether a strut of this code can be at block dexel k: all that it names is inside block and grid,
 * and no strut's owner is a vertex. `used` and `owner` have a byte a block dexel. */
static inline bool fixture_strut_fits(const struct dx_tile *tile, const struct dx_tiling *tiling,
                                      const uint8_t *used, uint32_t k, uint8_t code)
{
    struct dx_strut_corner triangle[DX_STRUT_MAX_TRIANGLES][3];
    unsigned n = dx_strut_triangles(triangle, code);

    for (unsigned m = 0; m < 3 * n; m++) {
        int p = (int)(k / DX_BLOCK) + triangle[m / 3][m % 3].row;
        int q = (int)(k % DX_BLOCK) + triangle[m / 3][m % 3].col;
        int64_t row = (int64_t)tile->row * DX_TILE_CELLS + p - 1;
        int64_t col = (int64_t)tile->col * DX_TILE_CELLS + q - 1;

        if (p < 0 || p >= DX_BLOCK || q < 0 || q >= DX_BLOCK || row < 0 || row >= tiling->height ||
            (!tiling->wrap && (col < 0 || col >= tiling->width)) || tile->strut[p * DX_BLOCK + q])
            return false;
    }
    return n > 0 && !used[k];
}

/* Up to `n` struts of random codes, wherever they fit. */
static inline void fixture_struts(struct dx_tile *tile, const struct dx_tiling *tiling, uint32_t n,
                                  struct dx_rng *rng)
{
    uint8_t used[DX_BLOCK_DEXELS], mask[DX_MASK_BYTES];
    /* the last row and column of dexels belong to the last tiles */
    uint32_t rows = tile->cell_rows + (uint32_t)(tile->row + 1u == tiling->rows);
    uint32_t cols = tile->cell_cols + (uint32_t)(!tiling->wrap && tile->col + 1u == tiling->cols);

    dx_tile_mask(tile, mask);
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        used[k] = mask[k / 8] >> (k % 8) & 1;
    for (uint32_t t = 0; t < n; t++) {
        uint32_t k = (1 + dx_rng_below(rng, rows)) * DX_BLOCK + 1 + dx_rng_below(rng, cols);
        uint8_t code = (uint8_t)(1 + dx_rng_below(rng, DX_STRUT_CODES - 1));
        struct dx_strut_corner triangle[DX_STRUT_MAX_TRIANGLES][3];

        if (tile->strut[k] || !fixture_strut_fits(tile, tiling, used, k, code))
            continue;
        tile->strut[k] = code;
        for (unsigned m = 0; m < 3 * dx_strut_triangles(triangle, code); m++)
            used[dx_tile_strut_corner(k, triangle[m / 3][m % 3])] = 1;
    }
}

/* Random normals where there is a vertex. */
static inline void fixture_normals(struct dx_tile *tile, struct dx_rng *rng)
{
    uint8_t mask[DX_MASK_BYTES];

    dx_tile_mask(tile, mask);
    tile->has_normals = true;
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++)
        for (uint32_t m = 2 * k; m < 2 * k + 2; m++)
            tile->normal[m] =
                mask[k / 8] >> (k % 8) & 1 ? (int8_t)((int)dx_rng_below(rng, 255) - 127) : 0;
}

/* A tile whose cells have a random outcome with probability `density` / 256, and with struts beside
 * them. Ranges and attributes are random where a vertex is, garbage-free elsewhere. */
static inline void fixture_tile(struct dx_tile *tile, const struct dx_tiling *tiling, uint32_t n,
                                uint8_t attr_bytes, uint32_t density, struct dx_rng *rng)
{
    uint8_t mask[DX_MASK_BYTES];

    memset(tile, 0, sizeof(*tile));
    tile->row = (uint16_t)(n / tiling->cols);
    tile->col = (uint16_t)(n % tiling->cols);
    tile->cell_rows = fixture_cells(tiling->cell_rows, tile->row);
    tile->cell_cols = fixture_cells(tiling->cell_cols, tile->col);
    tile->attr_bytes = attr_bytes;
    for (uint32_t i = 0; i < tile->cell_rows; i++)
        for (uint32_t j = 0; j < tile->cell_cols; j++)
            if (dx_rng_below(rng, 256) < density)
                tile->code[DX_TILE_CELLS * i + j] = (uint8_t)dx_rng_below(rng, 7);
    fixture_struts(tile, tiling, 8 * density, rng);
    dx_tile_mask(tile, mask);
    for (uint32_t k = 0; k < DX_BLOCK_DEXELS; k++) {
        if (!(mask[k / 8] >> (k % 8) & 1))
            continue;
        tile->range[k] = 1 + dx_rng_below(rng, 65535);
        if (attr_bytes)
            tile->attr[k] = (uint16_t)dx_rng_below(rng, attr_bytes == 1 ? 256 : 65536);
    }
}

/* A spinning scanner of the given size, all round or half round. */
static inline struct dx_geometry *fixture_geometry(uint32_t height, uint32_t width, bool wrap)
{
    const double step = (wrap ? 6.283185307179586 : 3.141592653589793) / width;
    struct dx_geometry *g;
    int r = dx_geometry_new_spinning(&g, height, width, 0, step, -0.5, 1.0 / height);

    assert(r == 0 && g->wrap == wrap);
    (void)r;
    return g;
}

/*
 * The small stream of docs/protocol.md: a pinhole of 3 x 3 dexels, one tile of 2 x 2 cells
 *   abc+acd  abd+bcd
 *   abc      none
 * with ranges 1000, 1001, ... mm in row-major order.
 */
static inline struct dx_geometry *fixture_small_geometry(void)
{
    struct dx_geometry *g;
    int r = dx_geometry_new(&g, DX_MODEL_PINHOLE, 3, 3);

    assert(r == 0);
    (void)r;
    for (int i = 0; i < 3; i++)
        g->table[i] = g->table[3 + i] = 0.5f * (float)(i - 1);
    dx_geometry_orient(g);
    assert(g->flip);
    return g;
}

static inline void fixture_small_tile(struct dx_tile *tile)
{
    memset(tile, 0, sizeof(*tile));
    tile->cell_rows = tile->cell_cols = 2;
    tile->code[0] = DX_CELL_ABC_ACD;
    tile->code[1] = DX_CELL_ABD_BCD;
    tile->code[DX_TILE_CELLS] = DX_CELL_ABC;
    for (uint32_t i = 0; i < 9; i++)
        tile->range[(i / 3 + 1) * DX_BLOCK + i % 3 + 1] = 1000 + i;
}

/* A tile's chunk. */
static inline size_t fixture_chunk(uint8_t *body, enum dx_encoding e, const struct dx_tile *tile,
                                   const struct dx_tiling *tiling, const struct dx_geometry *g)
{
    switch (e) {
    case DX_ENCODING_F32:
        return dx_chunk_put_f32(body, tile, tiling, g);
    case DX_ENCODING_Q16:
        return dx_chunk_put_q16(body, tile);
    default:
        return dx_chunk_put_delta(body, tile);
    }
}

static inline void fixture_subscribed(struct dx_msg_subscribed *m, const struct dx_geometry *g,
                                      enum dx_encoding encoding, uint8_t attr_bytes)
{
    struct dx_tiling t;

    dx_tiling_init(&t, g->height, g->width, g->wrap);
    *m = (struct dx_msg_subscribed){
        .stream = "test",
        .encoding = (uint8_t)encoding,
        .attr_bytes = attr_bytes,
        .model = (uint8_t)g->model,
        .wrap = g->wrap,
        .flip = g->flip,
        .range_bytes = g->range_bytes,
        .height = g->height,
        .width = g->width,
        .tile_rows = (uint16_t)t.rows,
        .tile_cols = (uint16_t)t.cols,
        .unit_m = g->unit_m,
        .table_bytes = dx_encoding_has_ranges(encoding) ? (uint32_t)(4 * g->n_table) : 0,
        .sigma = {0.002, 0, 0},
        .tilt_deg = 78.69,
        .noise_k = 4,
        .diag = 1,
    };
    memcpy(m->pose, g->pose, sizeof(m->pose));
}

/* What a server says, growing. */
struct script {
    uint8_t *bytes;
    size_t len, cap;
    uint32_t seq;
};

static inline void script_message(struct script *s, uint16_t type, uint16_t flags, uint64_t epoch,
                                  const void *body, size_t len)
{
    const struct dx_wire_header h = {.length = (uint32_t)len,
                                     .type = type,
                                     .flags = flags,
                                     .stream = 1,
                                     .seq = s->seq++,
                                     .epoch = epoch};

    if (s->len + DX_WIRE_HEADER_LEN + len > s->cap) {
        s->cap = 2 * (s->len + DX_WIRE_HEADER_LEN + len);
        s->bytes = realloc(s->bytes, s->cap);
    }
    assert(s->bytes);
    dx_wire_put_header(s->bytes + s->len, &h);
    if (len)
        memcpy(s->bytes + s->len + DX_WIRE_HEADER_LEN, body, len);
    s->len += DX_WIRE_HEADER_LEN + len;
}

#define SCRIPT_PUT(s, type, name, msg)                                                             \
    do {                                                                                           \
        uint8_t script_body[DX_WIRE_GEOMETRY_PIECE + 64];                                          \
        struct dx_writer script_w = dx_writer_init(script_body, sizeof(script_body));              \
        dx_msg_##name##_put(&script_w, msg);                                                       \
        assert(!script_w.failed);                                                                  \
        script_message(s, type, 0, 0, script_body, (size_t)(script_w.p - script_body));            \
    } while (0)

static inline void script_welcome(struct script *s)
{
    const struct dx_msg_welcome m = {.major = DX_WIRE_MAJOR,
                                     .minor = DX_WIRE_MINOR,
                                     .encodings = (1u << DX_N_ENCODINGS) - 1,
                                     .max_body = DX_WIRE_MAX_BODY,
                                     .n_streams = 1,
                                     .server = "test server"};

    SCRIPT_PUT(s, DX_MSG_WELCOME, welcome, &m);
}

static inline void script_geometry(struct script *s, const struct dx_geometry *g, uint32_t piece)
{
    const uint32_t total = (uint32_t)(4 * g->n_table);
    uint8_t *bytes = malloc(total);

    assert(bytes);
    dx_put_f32s(bytes, g->table, g->n_table);
    for (uint32_t at = 0; at < total; at += piece) {
        const struct dx_msg_geometry m = {.offset = at,
                                          .total = total,
                                          .len = total - at < piece ? total - at : piece,
                                          .bytes = bytes + at};

        SCRIPT_PUT(s, DX_MSG_GEOMETRY, geometry, &m);
    }
    free(bytes);
}

static inline void script_subscribed_to(struct script *s, const struct dx_geometry *g,
                                        enum dx_encoding encoding, uint8_t attr_bytes, bool normals)
{
    struct dx_msg_subscribed m;

    fixture_subscribed(&m, g, encoding, attr_bytes);
    m.normals = normals;
    SCRIPT_PUT(s, DX_MSG_SUBSCRIBED, subscribed, &m);
    if (m.table_bytes)
        script_geometry(s, g, 1000);
}

static inline void script_subscribed(struct script *s, const struct dx_geometry *g,
                                     enum dx_encoding encoding, uint8_t attr_bytes)
{
    script_subscribed_to(s, g, encoding, attr_bytes, false);
}

static inline void script_commit(struct script *s, uint64_t epoch, uint32_t n_tiles)
{
    const struct dx_msg_commit m = {.frame = epoch + 100,
                                    .host_ns = 1,
                                    .device_ns = 2,
                                    .clock_id = 3,
                                    .n_dropped = 4,
                                    .n_tiles = n_tiles,
                                    .flags = DX_COMMIT_PARTIAL | DX_COMMIT_CAP_LAST};
    uint8_t body[64];
    struct dx_writer w = dx_writer_init(body, sizeof(body));

    dx_msg_commit_put(&w, &m);
    script_message(s, DX_MSG_COMMIT, 0, epoch, body, (size_t)(w.p - body));
}

static inline void script_tile(struct script *s, enum dx_encoding encoding, uint64_t epoch,
                               const struct dx_tile *tile, const struct dx_tiling *tiling,
                               const struct dx_geometry *g)
{
    static uint8_t body[DX_WIRE_MAX_BODY];
    size_t len;

    len = fixture_chunk(body, encoding, tile, tiling, g);
    assert(len <= dx_chunk_max_len(encoding));
    script_message(s, DX_MSG_TILE, 0, epoch, body, len);
}

static inline void script_state(struct script *s, uint8_t state, const char *reason)
{
    struct dx_msg_stream_state m = {.state = state};

    assert(strlen(reason) < sizeof(m.reason));
    memcpy(m.reason, reason, strlen(reason));
    SCRIPT_PUT(s, DX_MSG_STREAM_STATE, stream_state, &m);
}

static inline void script_reset(struct script *s, const char *reason)
{
    struct dx_msg_reset m = {0};

    assert(strlen(reason) < sizeof(m.reason));
    memcpy(m.reason, reason, strlen(reason));
    SCRIPT_PUT(s, DX_MSG_RESET, reset, &m);
}

static inline void script_error(struct script *s, uint16_t code, const char *text)
{
    struct dx_msg_error m = {.code = code};

    assert(strlen(text) < sizeof(m.text));
    memcpy(m.text, text, strlen(text));
    SCRIPT_PUT(s, DX_MSG_ERROR, error, &m);
}

#endif
