/* Which codec a compression is; "none" is a copy. */
#include "drivers/file/mcap_pack.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name;
    const struct dx_mcap_codec *codec; /* NULL: none */
} compressions[DX_MCAP_N_COMPRESSIONS] = {
    [DX_MCAP_NONE] = {"", NULL},
    [DX_MCAP_LZ4] = {"lz4", &dx_mcap_lz4},
    [DX_MCAP_ZSTD] = {"zstd", &dx_mcap_zstd},
};

struct dx_mcap_packer {
    const struct dx_mcap_codec *codec;
    void *ctx;
};

struct dx_mcap_unpacker {
    void *ctx[DX_MCAP_N_COMPRESSIONS];
};

const char *dx_mcap_compression_name(enum dx_mcap_compression c)
{
    return compressions[c].name;
}

int dx_mcap_compression_find(struct dx_mcap_text name)
{
    for (int c = 0; c < DX_MCAP_N_COMPRESSIONS; c++)
        if (strlen(compressions[c].name) == name.len &&
            (name.len == 0 || memcmp(compressions[c].name, name.p, name.len) == 0))
            return c;
    return -EINVAL;
}

int dx_mcap_packer_new(struct dx_mcap_packer **out, enum dx_mcap_compression c, int level,
                       size_t max_len)
{
    struct dx_mcap_packer *p = calloc(1, sizeof(*p));

    if (!p)
        return -ENOMEM;
    p->codec = compressions[c].codec;
    p->ctx = p->codec ? p->codec->pack_new(level, max_len) : NULL;
    if (p->codec && !p->ctx) {
        free(p);
        return -ENOMEM;
    }
    *out = p;
    return 0;
}

void dx_mcap_packer_free(struct dx_mcap_packer *p)
{
    if (p && p->codec)
        p->codec->pack_free(p->ctx);
    free(p);
}

size_t dx_mcap_packer_bound(const struct dx_mcap_packer *p, size_t len)
{
    return p->codec ? p->codec->bound(len) : len;
}

int64_t dx_mcap_packer_run(struct dx_mcap_packer *p, uint8_t *out, size_t room, const uint8_t *in,
                           size_t len)
{
    if (p->codec)
        return p->codec->pack(p->ctx, out, room, in, len);
    memcpy(out, in, len);
    return (int64_t)len;
}

int dx_mcap_unpacker_new(struct dx_mcap_unpacker **out)
{
    struct dx_mcap_unpacker *u = calloc(1, sizeof(*u));

    if (!u)
        return -ENOMEM;
    *out = u;
    return 0;
}

void dx_mcap_unpacker_free(struct dx_mcap_unpacker *u)
{
    for (int c = 0; u && c < DX_MCAP_N_COMPRESSIONS; c++)
        if (u->ctx[c])
            compressions[c].codec->unpack_free(u->ctx[c]);
    free(u);
}

int dx_mcap_unpacker_run(struct dx_mcap_unpacker *u, enum dx_mcap_compression c, uint8_t *out,
                         size_t len, const uint8_t *in, size_t in_len)
{
    const struct dx_mcap_codec *codec = compressions[c].codec;

    if (codec && !u->ctx[c])
        u->ctx[c] = codec->unpack_new();
    if (codec)
        return u->ctx[c] ? codec->unpack(u->ctx[c], out, len, in, in_len) : -ENOMEM;
    if (len != in_len)
        return -EBADMSG;
    if (len)
        memcpy(out, in, len);
    return 0;
}
