/*
 * The compressions of MCAP chunks: none, lz4 (its frame format), zstd. A packer and an unpacker
 * hold the library's context, made once; each belongs to one thread.
 */
#ifndef DX_MCAP_PACK_H
#define DX_MCAP_PACK_H

#include "drivers/file/mcap.h"

enum dx_mcap_compression { DX_MCAP_NONE, DX_MCAP_LZ4, DX_MCAP_ZSTD, DX_MCAP_N_COMPRESSIONS };

/* As a chunk names it: "", "lz4", "zstd". */
const char *dx_mcap_compression_name(enum dx_mcap_compression c);
/* Negative: a name that is none of these. */
int dx_mcap_compression_find(struct dx_mcap_text name);

/* One compression: what it costs to pack and how. NULL slots for "none", which needs no copy. */
struct dx_mcap_packer;
/* `level`: 0 the default of a recording (zstd 1, lz4 fast). `max_len`: the largest input. -ENOMEM.
 */
int dx_mcap_packer_new(struct dx_mcap_packer **out, enum dx_mcap_compression c, int level,
                       size_t max_len);
void dx_mcap_packer_free(struct dx_mcap_packer *p);
/* Bytes of room that an input of `len` may need. */
size_t dx_mcap_packer_bound(const struct dx_mcap_packer *p, size_t len);
/* Packs; the length, or -ENOMEM. The room is at least the bound. */
int64_t dx_mcap_packer_run(struct dx_mcap_packer *p, uint8_t *out, size_t room, const uint8_t *in,
                           size_t len);

/* For all of them; the context of each is made when it is first needed. */
struct dx_mcap_unpacker;
int dx_mcap_unpacker_new(struct dx_mcap_unpacker **out);
void dx_mcap_unpacker_free(struct dx_mcap_unpacker *u);
/* Unpacks to exactly `len` bytes, all of the input. -EBADMSG: damaged, or another length. -ENOMEM.
 */
int dx_mcap_unpacker_run(struct dx_mcap_unpacker *u, enum dx_mcap_compression c, uint8_t *out,
                         size_t len, const uint8_t *in, size_t in_len);

/* ---- the libraries, a file each: mcap_zstd.c, mcap_lz4.c --------------------------------------
 */

struct dx_mcap_codec {
    void *(*pack_new)(int level, size_t max_len); /* NULL: no memory */
    void (*pack_free)(void *ctx);
    size_t (*bound)(size_t len);
    int64_t (*pack)(void *ctx, uint8_t *out, size_t room, const uint8_t *in, size_t len);
    void *(*unpack_new)(void);
    void (*unpack_free)(void *ctx);
    int (*unpack)(void *ctx, uint8_t *out, size_t len, const uint8_t *in, size_t in_len);
};

extern const struct dx_mcap_codec dx_mcap_lz4, dx_mcap_zstd;

#endif
