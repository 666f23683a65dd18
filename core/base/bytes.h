/*
 * Little-endian bytes, explicitly: single values at an address, and a reader and a writer that
 * cannot leave their buffer. A reader or writer that ran out stays failed, so that a decoder checks
 * once at its end; a failed reader yields zeros.
 */
#ifndef DX_BYTES_H
#define DX_BYTES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Elements of a message in place: they begin at any byte. In the host's order until they are whole
 * (dx_order_...). */
typedef float dx_packed_f32 __attribute__((aligned(1), may_alias));
typedef uint16_t dx_packed_u16 __attribute__((aligned(1), may_alias));

static inline void dx_put_u16(uint8_t *p, uint16_t v)
{
    p[0] = (uint8_t)v;
    p[1] = (uint8_t)(v >> 8);
}

static inline void dx_put_u32(uint8_t *p, uint32_t v)
{
    dx_put_u16(p, (uint16_t)v);
    dx_put_u16(p + 2, (uint16_t)(v >> 16));
}

static inline void dx_put_u64(uint8_t *p, uint64_t v)
{
    dx_put_u32(p, (uint32_t)v);
    dx_put_u32(p + 4, (uint32_t)(v >> 32));
}

static inline uint16_t dx_get_u16(const uint8_t *p)
{
    return (uint16_t)(p[0] | p[1] << 8);
}

static inline uint32_t dx_get_u32(const uint8_t *p)
{
    return dx_get_u16(p) | (uint32_t)dx_get_u16(p + 2) << 16;
}

static inline uint64_t dx_get_u64(const uint8_t *p)
{
    return dx_get_u32(p) | (uint64_t)dx_get_u32(p + 4) << 32;
}

static inline uint32_t dx_f32_bits(float f)
{
    uint32_t v;

    memcpy(&v, &f, sizeof(v));
    return v;
}

static inline float dx_f32_from_bits(uint32_t v)
{
    float f;

    memcpy(&f, &v, sizeof(f));
    return f;
}

static inline uint64_t dx_f64_bits(double f)
{
    uint64_t v;

    memcpy(&v, &f, sizeof(v));
    return v;
}

static inline double dx_f64_from_bits(uint64_t v)
{
    double f;

    memcpy(&f, &v, sizeof(f));
    return f;
}

/* Folded by the compiler: arrays below become one memcpy where the host counts as the wire does. */
static inline bool dx_host_is_little_endian(void)
{
    const uint16_t one = 1;
    uint8_t first;

    memcpy(&first, &one, 1);
    return first == 1;
}

static inline void dx_put_u16s(uint8_t *p, const uint16_t *v, size_t n)
{
    if (dx_host_is_little_endian()) {
        memcpy(p, v, 2 * n);
        return;
    }
    for (size_t i = 0; i < n; i++)
        dx_put_u16(p + 2 * i, v[i]);
}

static inline void dx_get_u16s(uint16_t *v, const uint8_t *p, size_t n)
{
    if (dx_host_is_little_endian()) {
        memcpy(v, p, 2 * n);
        return;
    }
    for (size_t i = 0; i < n; i++)
        v[i] = dx_get_u16(p + 2 * i);
}

static inline void dx_put_f32s(uint8_t *p, const float *v, size_t n)
{
    if (dx_host_is_little_endian()) {
        memcpy(p, v, 4 * n);
        return;
    }
    for (size_t i = 0; i < n; i++)
        dx_put_u32(p + 4 * i, dx_f32_bits(v[i]));
}

/* n elements that were written in place. */
static inline void dx_order_f32s(uint8_t *p, size_t n)
{
    for (size_t i = 0; i < n && !dx_host_is_little_endian(); i++)
        dx_put_u32(p + 4 * i, dx_f32_bits(((const dx_packed_f32 *)p)[i]));
}

static inline void dx_order_u16s(uint8_t *p, size_t n)
{
    for (size_t i = 0; i < n && !dx_host_is_little_endian(); i++)
        dx_put_u16(p + 2 * i, ((const dx_packed_u16 *)p)[i]);
}

static inline void dx_get_f32s(float *v, const uint8_t *p, size_t n)
{
    if (dx_host_is_little_endian()) {
        memcpy(v, p, 4 * n);
        return;
    }
    for (size_t i = 0; i < n; i++)
        v[i] = dx_f32_from_bits(dx_get_u32(p + 4 * i));
}

struct dx_reader {
    const uint8_t *p, *end;
    bool failed;
};

static inline struct dx_reader dx_reader_init(const void *bytes, size_t len)
{
    return (struct dx_reader){bytes, (const uint8_t *)bytes + len, false};
}

static inline size_t dx_reader_left(const struct dx_reader *r)
{
    return (size_t)(r->end - r->p);
}

/* The next `len` bytes, or NULL (and the reader has failed). */
static inline const uint8_t *dx_read_bytes(struct dx_reader *r, size_t len)
{
    const uint8_t *p = r->p;

    if (r->failed || len > dx_reader_left(r)) {
        r->failed = true;
        return NULL;
    }
    r->p += len;
    return p;
}

static inline uint8_t dx_read_u8(struct dx_reader *r)
{
    const uint8_t *p = dx_read_bytes(r, 1);

    return p ? *p : 0;
}

static inline uint16_t dx_read_u16(struct dx_reader *r)
{
    const uint8_t *p = dx_read_bytes(r, 2);

    return p ? dx_get_u16(p) : 0;
}

static inline uint32_t dx_read_u32(struct dx_reader *r)
{
    const uint8_t *p = dx_read_bytes(r, 4);

    return p ? dx_get_u32(p) : 0;
}

static inline uint64_t dx_read_u64(struct dx_reader *r)
{
    const uint8_t *p = dx_read_bytes(r, 8);

    return p ? dx_get_u64(p) : 0;
}

static inline float dx_read_f32(struct dx_reader *r)
{
    return dx_f32_from_bits(dx_read_u32(r));
}

static inline double dx_read_f64(struct dx_reader *r)
{
    return dx_f64_from_bits(dx_read_u64(r));
}

struct dx_writer {
    uint8_t *p, *end;
    bool failed;
};

static inline struct dx_writer dx_writer_init(void *bytes, size_t len)
{
    return (struct dx_writer){bytes, (uint8_t *)bytes + len, false};
}

/* Room for `len` bytes to be filled by the caller, or NULL (and the writer has failed). */
static inline uint8_t *dx_write_room(struct dx_writer *w, size_t len)
{
    uint8_t *p = w->p;

    if (w->failed || len > (size_t)(w->end - w->p)) {
        w->failed = true;
        return NULL;
    }
    w->p += len;
    return p;
}

static inline void dx_write_bytes(struct dx_writer *w, const void *bytes, size_t len)
{
    uint8_t *p = dx_write_room(w, len);

    if (p && len)
        memcpy(p, bytes, len);
}

static inline void dx_write_u8(struct dx_writer *w, uint8_t v)
{
    dx_write_bytes(w, &v, 1);
}

static inline void dx_write_u16(struct dx_writer *w, uint16_t v)
{
    uint8_t *p = dx_write_room(w, 2);

    if (p)
        dx_put_u16(p, v);
}

static inline void dx_write_u32(struct dx_writer *w, uint32_t v)
{
    uint8_t *p = dx_write_room(w, 4);

    if (p)
        dx_put_u32(p, v);
}

static inline void dx_write_u64(struct dx_writer *w, uint64_t v)
{
    uint8_t *p = dx_write_room(w, 8);

    if (p)
        dx_put_u64(p, v);
}

static inline void dx_write_f32(struct dx_writer *w, float v)
{
    dx_write_u32(w, dx_f32_bits(v));
}

static inline void dx_write_f64(struct dx_writer *w, double v)
{
    dx_write_u64(w, dx_f64_bits(v));
}

#endif
