/* MCAP chunks in the frame format of LZ4. The one file that includes lz4. */
#include "drivers/file/mcap_pack.h"

#include <errno.h>
#include <lz4frame.h>
#include <stdlib.h>

static void *lz4_pack_new(int level, size_t max_len)
{
    LZ4F_preferences_t *prefs = calloc(1, sizeof(*prefs));

    (void)max_len; /* its tables are on the stack */
    if (!prefs)
        return NULL;
    prefs->frameInfo.blockSizeID = LZ4F_max1MB;
    prefs->frameInfo.blockMode = LZ4F_blockLinked;
    prefs->compressionLevel = level;
    return prefs;
}

static void lz4_pack_free(void *ctx)
{
    free(ctx);
}

/* With room for either size of block. */
static size_t lz4_bound(size_t len)
{
    const LZ4F_preferences_t prefs = {.frameInfo.blockSizeID = LZ4F_max1MB};

    return LZ4F_compressFrameBound(len, &prefs);
}

static int64_t lz4_pack(void *ctx, uint8_t *out, size_t room, const uint8_t *in, size_t len)
{
    size_t n = LZ4F_compressFrame(out, room, in, len, ctx);

    return LZ4F_isError(n) ? -ENOMEM : (int64_t)n;
}

static void *lz4_unpack_new(void)
{
    LZ4F_dctx *ctx = NULL;

    return LZ4F_isError(LZ4F_createDecompressionContext(&ctx, LZ4F_VERSION)) ? NULL : ctx;
}

static void lz4_unpack_free(void *ctx)
{
    LZ4F_freeDecompressionContext(ctx);
}

/* One frame or several. The library's own buffers are two blocks of at most 4 MiB. */
static int lz4_unpack(void *ctx, uint8_t *out, size_t len, const uint8_t *in, size_t in_len)
{
    size_t done = 0, used = 0, hint = 0;

    LZ4F_resetDecompressionContext(ctx);
    while (used < in_len) {
        size_t n_out = len - done, n_in = in_len - used;

        hint = LZ4F_decompress(ctx, out + done, &n_out, in + used, &n_in, NULL);
        if (LZ4F_isError(hint) || (n_out == 0 && n_in == 0))
            return -EBADMSG;
        done += n_out;
        used += n_in;
    }
    return done == len && hint == 0 ? 0 : -EBADMSG;
}

const struct dx_mcap_codec dx_mcap_lz4 = {lz4_pack_new,   lz4_pack_free,   lz4_bound, lz4_pack,
                                          lz4_unpack_new, lz4_unpack_free, lz4_unpack};
