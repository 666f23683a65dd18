/* Plain CDR to bytes and back. */
#include "drivers/file/cdr.h"

static const uint8_t head_little[DX_CDR_HEAD] = {0, 1, 0, 0};

/* ---- writing ----------------------------------------------------------------------------------
 */

/* The next `len` bytes, or NULL where they do not fit. */
static uint8_t *room(struct dx_cdr_writer *w, size_t len)
{
    uint8_t *p = NULL;

    if (w->len <= w->cap && len <= w->cap - w->len)
        p = w->bytes + w->len;
    w->len += len;
    return p;
}

static size_t padding(size_t at, size_t size)
{
    return (size - (at - DX_CDR_HEAD) % size) % size;
}

static void align(struct dx_cdr_writer *w, size_t size)
{
    size_t n = padding(w->len, size);
    uint8_t *p = n ? room(w, n) : NULL;

    if (p)
        memset(p, 0, n);
}

struct dx_cdr_writer dx_cdr_writer_init(uint8_t *bytes, size_t cap)
{
    struct dx_cdr_writer w = {bytes, cap, 0};
    uint8_t *p = room(&w, DX_CDR_HEAD);

    if (p)
        memcpy(p, head_little, DX_CDR_HEAD);
    return w;
}

void dx_cdr_put_u8(struct dx_cdr_writer *w, uint8_t v)
{
    uint8_t *p = room(w, 1);

    if (p)
        *p = v;
}

void dx_cdr_put_u32(struct dx_cdr_writer *w, uint32_t v)
{
    uint8_t *p;

    align(w, 4);
    p = room(w, 4);
    if (p)
        dx_put_u32(p, v);
}

void dx_cdr_put_f64(struct dx_cdr_writer *w, double v)
{
    uint8_t *p;

    align(w, 8);
    p = room(w, 8);
    if (p)
        dx_put_u64(p, dx_f64_bits(v));
}

void dx_cdr_put_text(struct dx_cdr_writer *w, const char *text, size_t len)
{
    uint8_t *p;

    dx_cdr_put_u32(w, (uint32_t)len + 1);
    p = room(w, len + 1);
    if (!p)
        return;
    if (len)
        memcpy(p, text, len);
    p[len] = 0;
}

uint8_t *dx_cdr_put_room(struct dx_cdr_writer *w, size_t len)
{
    dx_cdr_put_u32(w, (uint32_t)len);
    return room(w, len);
}

/* ---- reading ----------------------------------------------------------------------------------
 */

static const uint8_t *take(struct dx_cdr_reader *r, size_t len)
{
    const uint8_t *p;

    if (r->failed || len > r->len - r->at) {
        r->failed = true;
        return NULL;
    }
    p = r->bytes + r->at;
    r->at += len;
    return p;
}

static const uint8_t *take_aligned(struct dx_cdr_reader *r, size_t size)
{
    if (!r->failed && !take(r, padding(r->at, size)))
        return NULL;
    return take(r, size);
}

/* The third and fourth byte are options that plain CDR has no use for. */
struct dx_cdr_reader dx_cdr_reader_init(const uint8_t *bytes, size_t len)
{
    struct dx_cdr_reader r = {bytes, len, 0, false, false};
    const uint8_t *p = take(&r, DX_CDR_HEAD);

    if (!p || p[0] != 0 || p[1] > 1)
        r.failed = true;
    else
        r.is_big = p[1] == 0;
    return r;
}

uint8_t dx_cdr_get_u8(struct dx_cdr_reader *r)
{
    const uint8_t *p = take(r, 1);

    return p ? *p : 0;
}

uint32_t dx_cdr_get_u32(struct dx_cdr_reader *r)
{
    const uint8_t *p = take_aligned(r, 4);
    uint32_t v = p ? dx_get_u32(p) : 0;

    return r->is_big ? __builtin_bswap32(v) : v;
}

double dx_cdr_get_f64(struct dx_cdr_reader *r)
{
    const uint8_t *p = take_aligned(r, 8);
    uint64_t v = p ? dx_get_u64(p) : 0;

    return dx_f64_from_bits(r->is_big ? __builtin_bswap64(v) : v);
}

/* Its length counts the NUL; some writers give an empty string the length 0. */
const char *dx_cdr_get_text(struct dx_cdr_reader *r, uint32_t *len)
{
    uint32_t n = dx_cdr_get_u32(r);
    const uint8_t *p = take(r, n);

    *len = 0;
    if (!p || n == 0)
        return r->failed ? NULL : "";
    if (p[n - 1] != 0) {
        r->failed = true;
        return NULL;
    }
    *len = n - 1;
    return (const char *)p;
}

const uint8_t *dx_cdr_get_bytes(struct dx_cdr_reader *r, uint32_t *len)
{
    uint32_t n = dx_cdr_get_u32(r);
    const uint8_t *p = take(r, n);

    *len = p ? n : 0;
    return p;
}

uint32_t dx_cdr_get_count(struct dx_cdr_reader *r, size_t min_len)
{
    uint32_t n = dx_cdr_get_u32(r);

    if (r->failed || n > (r->len - r->at) / min_len) {
        r->failed = true;
        return 0;
    }
    return n;
}
