/*
 * Bodies of all messages but TILE (chunk_put.c, chunk_get.c). Fixed fields come first and the text
 * last, so that every field but the text has a fixed offset: those of docs/protocol.md. Pure
 * functions; any thread.
 */
#include "core/wire/wire.h"

#include <errno.h>
#include <math.h>

#include "core/grid/plane.h"
#include "core/grid/tile.h"

static bool is_control(uint8_t c)
{
    return c < 0x20 || c == 0x7f;
}

/* Control bytes go out as spaces: a text ends up in logs and on terminals. */
static void put_text(struct dx_writer *w, const char *text, size_t room)
{
    size_t len = strnlen(text, room - 1);
    uint8_t *p;

    dx_write_u16(w, (uint16_t)len);
    p = dx_write_room(w, len);
    for (size_t i = 0; p && i < len; i++)
        p[i] = is_control((uint8_t)text[i]) ? ' ' : (uint8_t)text[i];
}

/* A text longer than its room is cut; a control byte fails the reader. */
static void get_text(struct dx_reader *r, char *text, size_t room)
{
    size_t len = dx_read_u16(r);
    const uint8_t *p = dx_read_bytes(r, len);
    size_t kept = p ? (len < room ? len : room - 1) : 0;

    for (size_t i = 0; p && i < len; i++)
        r->failed |= is_control(p[i]);
    if (kept)
        memcpy(text, p, kept);
    text[kept] = 0;
}

/* A name that was cut would be another name. */
static void get_name(struct dx_reader *r, char *name)
{
    if (dx_reader_left(r) >= 2 && dx_get_u16(r->p) >= DX_WIRE_NAME)
        r->failed = true;
    get_text(r, name, DX_WIRE_NAME);
}

static int end(const struct dx_reader *r, bool in_range)
{
    return !r->failed && dx_reader_left(r) == 0 && in_range ? 0 : -EBADMSG;
}

void dx_wire_put_header(uint8_t out[DX_WIRE_HEADER_LEN], const struct dx_wire_header *h)
{
    dx_put_u32(out, h->length);
    dx_put_u16(out + 4, h->type);
    dx_put_u16(out + 6, h->flags);
    dx_put_u32(out + 8, h->stream);
    dx_put_u32(out + 12, h->seq);
    dx_put_u64(out + 16, h->epoch);
}

void dx_wire_get_header(struct dx_wire_header *h, const uint8_t in[DX_WIRE_HEADER_LEN])
{
    h->length = dx_get_u32(in);
    h->type = dx_get_u16(in + 4);
    h->flags = dx_get_u16(in + 6);
    h->stream = dx_get_u32(in + 8);
    h->seq = dx_get_u32(in + 12);
    h->epoch = dx_get_u64(in + 16);
}

void dx_msg_hello_put(struct dx_writer *w, const struct dx_msg_hello *m)
{
    dx_write_u32(w, DX_WIRE_MAGIC);
    dx_write_u16(w, m->major);
    dx_write_u16(w, m->minor);
    dx_write_u32(w, m->features);
    dx_write_u32(w, m->encodings);
}

int dx_msg_hello_get(struct dx_msg_hello *m, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);
    uint32_t magic = dx_read_u32(&r);

    m->major = dx_read_u16(&r);
    m->minor = dx_read_u16(&r);
    m->features = dx_read_u32(&r);
    m->encodings = dx_read_u32(&r);
    /* What a later version says besides comes after what every version says. */
    if (m->major != DX_WIRE_MAJOR || dx_wire_minor(m->minor) != m->minor)
        dx_read_bytes(&r, dx_reader_left(&r));
    return end(&r, magic == DX_WIRE_MAGIC);
}

void dx_msg_welcome_put(struct dx_writer *w, const struct dx_msg_welcome *m)
{
    dx_write_u32(w, DX_WIRE_MAGIC);
    dx_write_u16(w, m->major);
    dx_write_u16(w, m->minor);
    dx_write_u32(w, m->features);
    dx_write_u32(w, m->encodings);
    dx_write_u32(w, m->max_body);
    dx_write_u32(w, m->n_streams);
    put_text(w, m->server, sizeof(m->server));
}

int dx_msg_welcome_get(struct dx_msg_welcome *m, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);
    uint32_t magic = dx_read_u32(&r);

    m->major = dx_read_u16(&r);
    m->minor = dx_read_u16(&r);
    m->features = dx_read_u32(&r);
    m->encodings = dx_read_u32(&r);
    m->max_body = dx_read_u32(&r);
    m->n_streams = dx_read_u32(&r);
    get_text(&r, m->server, sizeof(m->server));
    return end(&r, magic == DX_WIRE_MAGIC && m->max_body <= DX_WIRE_MAX_BODY);
}

void dx_msg_error_put(struct dx_writer *w, const struct dx_msg_error *m)
{
    dx_write_u16(w, m->code);
    put_text(w, m->text, sizeof(m->text));
}

int dx_msg_error_get(struct dx_msg_error *m, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    m->code = dx_read_u16(&r);
    get_text(&r, m->text, sizeof(m->text));
    return end(&r, true);
}

void dx_msg_subscribe_put(struct dx_writer *w, const struct dx_msg_subscribe *m)
{
    dx_write_u8(w, m->encoding);
    dx_write_u8(w, m->mode);
    dx_write_u8(w, m->want);
    dx_write_u8(w, m->lod.stride);
    dx_write_u32(w, m->min_interval_ms);
    dx_write_u16(w, m->tile_row0);
    dx_write_u16(w, m->tile_col0);
    dx_write_u16(w, m->n_tile_rows);
    dx_write_u16(w, m->n_tile_cols);
    dx_write_u16(w, m->lod.bound);
    put_text(w, m->stream, sizeof(m->stream));
}

int dx_msg_subscribe_get(struct dx_msg_subscribe *m, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    m->encoding = dx_read_u8(&r);
    m->mode = dx_read_u8(&r);
    m->want = dx_read_u8(&r);
    m->lod.stride = dx_read_u8(&r);
    m->min_interval_ms = dx_read_u32(&r);
    m->tile_row0 = dx_read_u16(&r);
    m->tile_col0 = dx_read_u16(&r);
    m->n_tile_rows = dx_read_u16(&r);
    m->n_tile_cols = dx_read_u16(&r);
    m->lod.bound = dx_read_u16(&r);
    get_name(&r, m->stream);
    return end(&r, m->encoding < DX_N_ENCODINGS && m->mode <= DX_MODE_LOSSLESS &&
                       m->want <= (DX_WANT_ATTR | DX_WANT_NORMALS) &&
                       !m->n_tile_rows == !m->n_tile_cols);
}

void dx_msg_subscribed_put(struct dx_writer *w, const struct dx_msg_subscribed *m)
{
    const uint8_t bytes[12] = {m->encoding, m->mode,    m->attr_bytes,  m->model,
                               m->wrap,     m->flip,    m->range_bytes, m->diag,
                               m->paper,    m->normals, m->smooth,      m->lod.stride};

    dx_write_bytes(w, bytes, sizeof(bytes));
    dx_write_u32(w, m->height);
    dx_write_u32(w, m->width);
    dx_write_u16(w, m->tile_rows);
    dx_write_u16(w, m->tile_cols);
    dx_write_f32(w, m->unit_m);
    dx_write_u32(w, m->table_bytes);
    for (int i = 0; i < 12; i++)
        dx_write_f64(w, m->pose[i]);
    for (int i = 0; i < 3; i++)
        dx_write_f64(w, m->sigma[i]);
    dx_write_f64(w, m->tilt_deg);
    dx_write_f64(w, m->noise_k);
    dx_write_f64(w, m->cap_m);
    dx_write_u16(w, m->lod.bound);
    put_text(w, m->stream, sizeof(m->stream));
}

/* The sizes bound every later allocation and index of a client. */
static bool subscribed_sizes_ok(const struct dx_msg_subscribed *m)
{
    size_t n_table = dx_geometry_table_len(m->model, m->height, m->width);
    struct dx_tiling tiling;

    if (n_table == 0 || n_table > UINT32_MAX / sizeof(float) || m->height < 2 || m->width < 2 ||
        (m->wrap && m->width < 8))
        return false;
    dx_tiling_init(&tiling, m->height, m->width, m->wrap);
    if (tiling.rows != m->tile_rows || tiling.cols != m->tile_cols)
        return false;
    if (m->encoding == DX_ENCODING_Q16 && m->range_bytes != 2)
        return false;
    return m->table_bytes == (dx_encoding_has_ranges(m->encoding) ? n_table * sizeof(float) : 0);
}

static bool subscribed_numbers_ok(const struct dx_msg_subscribed *m)
{
    bool ok = isfinite(m->unit_m) && m->unit_m > 0 && isfinite(m->tilt_deg) &&
              isfinite(m->noise_k) && isfinite(m->cap_m);

    for (int i = 0; i < 12; i++)
        ok = ok && isfinite(m->pose[i]);
    for (int i = 0; i < 3; i++)
        ok = ok && isfinite(m->sigma[i]);
    return ok;
}

static bool subscribed_ok(const struct dx_msg_subscribed *m)
{
    return m->encoding < DX_N_ENCODINGS && m->mode <= DX_MODE_LOSSLESS && m->attr_bytes <= 2 &&
           m->model >= DX_MODEL_SPINNING && m->model <= DX_MODEL_TABLE && m->wrap <= 1 &&
           m->flip <= 1 && (m->range_bytes == 2 || m->range_bytes == 4) && m->diag <= 2 &&
           m->paper <= 1 && m->normals <= 1 && m->smooth <= 1 && !dx_lod_check(m->lod) &&
           (dx_lod_is_whole(m->lod) || !dx_encoding_has_ranges(m->encoding)) &&
           subscribed_sizes_ok(m) && subscribed_numbers_ok(m);
}

int dx_msg_subscribed_get(struct dx_msg_subscribed *m, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);
    uint8_t *bytes[12] = {&m->encoding, &m->mode,    &m->attr_bytes,  &m->model,
                          &m->wrap,     &m->flip,    &m->range_bytes, &m->diag,
                          &m->paper,    &m->normals, &m->smooth,      &m->lod.stride};

    for (int i = 0; i < 12; i++)
        *bytes[i] = dx_read_u8(&r);
    m->height = dx_read_u32(&r);
    m->width = dx_read_u32(&r);
    m->tile_rows = dx_read_u16(&r);
    m->tile_cols = dx_read_u16(&r);
    m->unit_m = dx_read_f32(&r);
    m->table_bytes = dx_read_u32(&r);
    for (int i = 0; i < 12; i++)
        m->pose[i] = dx_read_f64(&r);
    for (int i = 0; i < 3; i++)
        m->sigma[i] = dx_read_f64(&r);
    m->tilt_deg = dx_read_f64(&r);
    m->noise_k = dx_read_f64(&r);
    m->cap_m = dx_read_f64(&r);
    m->lod.bound = dx_read_u16(&r);
    get_name(&r, m->stream);
    return end(&r, subscribed_ok(m));
}

void dx_msg_geometry_put(struct dx_writer *w, const struct dx_msg_geometry *m)
{
    dx_write_u32(w, m->offset);
    dx_write_u32(w, m->total);
    dx_write_bytes(w, m->bytes, m->len);
}

int dx_msg_geometry_get(struct dx_msg_geometry *m, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);
    size_t n;

    m->offset = dx_read_u32(&r);
    m->total = dx_read_u32(&r);
    n = dx_reader_left(&r);
    m->bytes = dx_read_bytes(&r, n);
    m->len = (uint32_t)n;
    return end(&r, n > 0 && n <= DX_WIRE_GEOMETRY_PIECE && n % 4 == 0 && m->offset % 4 == 0 &&
                       m->offset <= m->total && n <= m->total - m->offset);
}

void dx_msg_commit_put(struct dx_writer *w, const struct dx_msg_commit *m)
{
    dx_write_u64(w, m->frame);
    dx_write_u64(w, m->host_ns);
    dx_write_u64(w, m->device_ns);
    dx_write_u64(w, m->n_dropped);
    dx_write_u32(w, m->clock_id);
    dx_write_u32(w, m->n_tiles);
    dx_write_u32(w, m->flags);
}

int dx_msg_commit_get(struct dx_msg_commit *m, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    m->frame = dx_read_u64(&r);
    m->host_ns = dx_read_u64(&r);
    m->device_ns = dx_read_u64(&r);
    m->n_dropped = dx_read_u64(&r);
    m->clock_id = dx_read_u32(&r);
    m->n_tiles = dx_read_u32(&r);
    m->flags = dx_read_u32(&r);
    return end(&r, m->clock_id <= 3);
}

void dx_msg_reset_put(struct dx_writer *w, const struct dx_msg_reset *m)
{
    put_text(w, m->reason, sizeof(m->reason));
}

int dx_msg_reset_get(struct dx_msg_reset *m, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    get_text(&r, m->reason, sizeof(m->reason));
    return end(&r, true);
}

void dx_msg_stream_state_put(struct dx_writer *w, const struct dx_msg_stream_state *m)
{
    dx_write_u8(w, m->state);
    put_text(w, m->reason, sizeof(m->reason));
}

int dx_msg_stream_state_get(struct dx_msg_stream_state *m, const uint8_t *body, size_t len)
{
    struct dx_reader r = dx_reader_init(body, len);

    m->state = dx_read_u8(&r);
    get_text(&r, m->reason, sizeof(m->reason));
    return end(&r, m->state <= DX_STREAM_FAULTED);
}

const char *dx_encoding_name(unsigned encoding)
{
    static const char *const names[DX_N_ENCODINGS] = {"f32", "q16", "delta"};

    return encoding < DX_N_ENCODINGS ? names[encoding] : "unknown";
}

const char *dx_mode_name(unsigned mode)
{
    static const char *const names[] = {"live", "pull", "lossless"};

    return mode <= DX_MODE_LOSSLESS ? names[mode] : "unknown";
}

int dx_encoding_from_name(const char *name)
{
    for (int e = 0; e < DX_N_ENCODINGS; e++)
        if (!strcmp(name, dx_encoding_name((unsigned)e)))
            return e;
    return -1;
}

const char *dx_stream_state_name(unsigned state)
{
    static const char *const names[] = {"opening", "live", "stalled", "gone", "ended", "faulted"};

    return state <= DX_STREAM_FAULTED ? names[state] : "unknown";
}
