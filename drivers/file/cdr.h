/*
 * CDR, the encoding of ROS 2 messages (XCDR version 1, plain): four bytes that tell the byte order,
 * then values, each aligned to its own size counted from behind those four bytes. Written in little
 * endian, read in either. A writer or reader that ran out stays failed; a failed reader yields
 * zeros.
 */
#ifndef DX_CDR_H
#define DX_CDR_H

#include "core/base/bytes.h"

#define DX_CDR_HEAD 4

struct dx_cdr_writer {
    uint8_t *bytes;
    size_t cap, len; /* len goes on counting when there is no room: what would have been needed */
};

/* Puts the head. `bytes` may be NULL with cap 0: the writer only counts. */
struct dx_cdr_writer dx_cdr_writer_init(uint8_t *bytes, size_t cap);
static inline bool dx_cdr_writer_failed(const struct dx_cdr_writer *w)
{
    return w->len > w->cap;
}
void dx_cdr_put_u8(struct dx_cdr_writer *w, uint8_t v);
void dx_cdr_put_u32(struct dx_cdr_writer *w, uint32_t v);
void dx_cdr_put_f64(struct dx_cdr_writer *w, double v);
/* A string of `len` bytes without NUL. */
void dx_cdr_put_text(struct dx_cdr_writer *w, const char *text, size_t len);
/* A sequence of bytes for the caller to fill: its address, NULL where it does not fit. */
uint8_t *dx_cdr_put_room(struct dx_cdr_writer *w, size_t len);

struct dx_cdr_reader {
    const uint8_t *bytes;
    size_t len, at;
    bool is_big, failed;
};

/* Fails on a head that is not plain CDR of version 1. */
struct dx_cdr_reader dx_cdr_reader_init(const uint8_t *bytes, size_t len);
uint8_t dx_cdr_get_u8(struct dx_cdr_reader *r);
uint32_t dx_cdr_get_u32(struct dx_cdr_reader *r);
double dx_cdr_get_f64(struct dx_cdr_reader *r);
/* Views into the bytes; a string without its NUL. */
const char *dx_cdr_get_text(struct dx_cdr_reader *r, uint32_t *len);
const uint8_t *dx_cdr_get_bytes(struct dx_cdr_reader *r, uint32_t *len);
/* The count of a sequence whose elements have at least `min_len` bytes each: fails where so many
 * cannot follow. */
uint32_t dx_cdr_get_count(struct dx_cdr_reader *r, size_t min_len);

#endif
