/* MCAP chunks as zstd frames. The one file that includes zstd. */
#include "drivers/file/mcap_pack.h"

#include <errno.h>
#include <stdlib.h>
#include <zstd.h>

#define DEFAULT_LEVEL 1

struct packer {
    ZSTD_CCtx *zstd;
    int level;
};

static void zstd_pack_free(void *ctx)
{
    struct packer *p = ctx;

    ZSTD_freeCCtx(p->zstd);
    free(p);
}

/* zstd makes its tables with the first input: one of the largest size now, so that they are there
 * before the recording starts. */
static int warm_up(struct packer *p, size_t max_len)
{
    uint8_t *in = calloc(1, max_len ? max_len : 1);
    size_t room = ZSTD_compressBound(max_len);
    uint8_t *out = malloc(room);
    size_t len = ZSTD_CONTENTSIZE_ERROR;

    if (in && out)
        len = ZSTD_compressCCtx(p->zstd, out, room, in, max_len, p->level);
    free(in);
    free(out);
    return ZSTD_isError(len) ? -ENOMEM : 0;
}

static void *zstd_pack_new(int level, size_t max_len)
{
    struct packer *p = malloc(sizeof(*p));

    if (!p)
        return NULL;
    p->level = level ? level : DEFAULT_LEVEL;
    p->zstd = ZSTD_createCCtx();
    if (!p->zstd || warm_up(p, max_len) < 0) {
        zstd_pack_free(p);
        return NULL;
    }
    return p;
}

/* With the room of the bound, only memory can be missing. */
static int64_t zstd_pack(void *ctx, uint8_t *out, size_t room, const uint8_t *in, size_t len)
{
    struct packer *p = ctx;
    size_t n = ZSTD_compressCCtx(p->zstd, out, room, in, len, p->level);

    return ZSTD_isError(n) ? -ENOMEM : (int64_t)n;
}

static void *zstd_unpack_new(void)
{
    return ZSTD_createDCtx();
}

static void zstd_unpack_free(void *ctx)
{
    ZSTD_freeDCtx(ctx);
}

/* The output is the window: nothing is allocated, whatever window a frame asks for. */
static int zstd_unpack(void *ctx, uint8_t *out, size_t len, const uint8_t *in, size_t in_len)
{
    size_t n = ZSTD_decompressDCtx(ctx, out, len, in, in_len);

    return ZSTD_isError(n) || n != len ? -EBADMSG : 0;
}

const struct dx_mcap_codec dx_mcap_zstd = {zstd_pack_new, zstd_pack_free,  ZSTD_compressBound,
                                           zstd_pack,     zstd_unpack_new, zstd_unpack_free,
                                           zstd_unpack};
