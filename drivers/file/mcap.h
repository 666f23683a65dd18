/*
 * MCAP, the container of recordings: the kinds of records, their fields, and the two small
 * interfaces through which a file is written and read. Layout: the MCAP specification, version 0.
 * Text and bytes of a record are views into the caller's memory; nothing here owns anything.
 */
#ifndef DX_MCAP_H
#define DX_MCAP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/*
 * Bounds of the reader, whatever a file claims (docs/recordings.md). A chunk, and a message outside
 * of chunks, is at most DX_MCAP_MAX_CHUNK; what is larger counts as damaged.
 */
#define DX_MCAP_MAX_CHUNK    ((size_t)64 << 20) /* decompressed */
#define DX_MCAP_MAX_DEFS     ((size_t)16 << 20) /* schemas and channels together */
#define DX_MCAP_MAX_CHUNKS   (1u << 20)
#define DX_MCAP_MAX_ITEMS    (1u << 16)          /* attachments; metadata records */
#define DX_MCAP_MAX_NAMES    ((size_t)16 << 20)  /* of attachments and metadata, all together */
#define DX_MCAP_MAX_METADATA ((size_t)1 << 20)   /* a metadata record */
#define DX_MCAP_MAX_CACHE    ((size_t)128 << 20) /* decompressed chunks kept by a reader */
#define DX_MCAP_MAX_PENDING  (1u << 22) /* messages of overlapping chunks, in log-time order */
#define DX_MCAP_MAX_AGAIN    ((uint64_t)1 << 30) /* and three times the chunks: loaded again */

#define DX_MCAP_MAGIC_LEN    8
#define DX_MCAP_RECORD_HEAD  9  /* opcode and length */
#define DX_MCAP_MESSAGE_HEAD 22 /* of a Message's body */
#define DX_MCAP_FOOTER_LEN   20 /* of a Footer's body */

extern const uint8_t dx_mcap_magic[DX_MCAP_MAGIC_LEN];

/* Positive results. */
enum dx_mcap_condition {
    DX_MCAP_E_END = 1,  /* reading: no message is left */
    DX_MCAP_E_FULL = 2, /* writing: the index has no room; finish this file and begin another */
};

enum dx_mcap_op {
    DX_MCAP_HEADER = 0x01,
    DX_MCAP_FOOTER = 0x02,
    DX_MCAP_SCHEMA = 0x03,
    DX_MCAP_CHANNEL = 0x04,
    DX_MCAP_MESSAGE = 0x05,
    DX_MCAP_CHUNK = 0x06,
    DX_MCAP_MESSAGE_INDEX = 0x07,
    DX_MCAP_CHUNK_INDEX = 0x08,
    DX_MCAP_ATTACHMENT = 0x09,
    DX_MCAP_ATTACHMENT_INDEX = 0x0a,
    DX_MCAP_STATISTICS = 0x0b,
    DX_MCAP_METADATA = 0x0c,
    DX_MCAP_METADATA_INDEX = 0x0d,
    DX_MCAP_SUMMARY_OFFSET = 0x0e,
    DX_MCAP_DATA_END = 0x0f,
};

/* Text that does not end in NUL. */
struct dx_mcap_text {
    const char *p;
    uint32_t len;
};

/* Bytes; also a map of texts in its encoded form (mcap_record.h reads and makes them). */
struct dx_mcap_bytes {
    const uint8_t *p;
    size_t len;
};

struct dx_mcap_schema {
    uint16_t id; /* not 0 */
    struct dx_mcap_text name, encoding;
    struct dx_mcap_bytes data;
};

struct dx_mcap_channel {
    uint16_t id, schema_id; /* schema 0: none */
    struct dx_mcap_text topic, message_encoding;
    struct dx_mcap_bytes metadata; /* map */
};

struct dx_mcap_message {
    uint16_t channel_id;
    uint32_t sequence;
    uint64_t log_time, publish_time; /* ns */
    struct dx_mcap_bytes data;
};

struct dx_mcap_chunk {
    uint64_t start, end; /* log times of its messages, ns; both 0 when it has none */
    uint64_t uncompressed_len;
    uint32_t crc;                    /* of the records uncompressed; 0: none */
    struct dx_mcap_text compression; /* "", "lz4", "zstd" */
    struct dx_mcap_bytes records;    /* as stored */
};

struct dx_mcap_attachment {
    uint64_t log_time, create_time; /* ns */
    struct dx_mcap_text name, media_type;
    struct dx_mcap_bytes data;
};

struct dx_mcap_metadata {
    struct dx_mcap_text name;
    struct dx_mcap_bytes map;
};

/* Where a record is, as an index tells it: with opcode and length. */
struct dx_mcap_extent {
    uint64_t offset, len;
};

struct dx_mcap_statistics {
    uint64_t n_messages;
    uint16_t n_schemas;
    uint32_t n_channels, n_attachments, n_metadata, n_chunks;
    uint64_t start, end;
    struct dx_mcap_bytes counts; /* map of u16 channel to u64 messages */
};

/*
 * Where a file is written: bytes at an offset. All or nothing is not asked for: after an error the
 * writer writes the same place again, or cuts it off. Both return 0 or -errno.
 */
struct dx_mcap_sink {
    void *ctx;
    int (*write)(void *ctx, uint64_t offset, const void *bytes, size_t len);
    int (*truncate)(void *ctx, uint64_t len);
};

/* Where a file is read: all `len` bytes at an offset that the file has, or -errno. */
struct dx_mcap_source {
    void *ctx;
    int (*read)(void *ctx, uint64_t offset, void *bytes, size_t len);
    uint64_t len; /* of the file */
};

/* A sink and a source over an open file; `fd` stays the caller's and must outlive them. It is
 * passed in the pointer itself, nothing is allocated. */
struct dx_mcap_sink dx_mcap_sink_fd(int fd);
/* Errors: from fstat; -EINVAL: not a regular file. */
int dx_mcap_source_fd(struct dx_mcap_source *out, int fd);

static inline bool dx_mcap_probe(const uint8_t *bytes, size_t len)
{
    for (size_t k = 0; k < DX_MCAP_MAGIC_LEN; k++)
        if (k >= len || bytes[k] != dx_mcap_magic[k])
            return false;
    return true;
}

#endif
