/* What the files of the MCAP writer share: its state, and the appending of whole pieces. */
#ifndef DX_MCAP_WRITE_PRIV_H
#define DX_MCAP_WRITE_PRIV_H

#include "drivers/file/mcap_defs.h"
#include "drivers/file/mcap_write.h"

#define DX_MCAP_STAGE    ((size_t)64 << 10)
#define DX_MCAP_MAX_NAME 1024

/* A message of the open chunk, in the list of its channel. */
struct dx_mcap_entry {
    uint64_t log_time;
    uint32_t offset; /* of its record in the chunk */
    uint32_t next;   /* DX_MCAP_NONE_LEFT: the last */
};

#define DX_MCAP_NONE_LEFT UINT32_MAX

/* A channel in the open chunk. */
struct dx_mcap_list {
    uint32_t first, last, n;
};

/* Records of one kind, kept for the summary. */
struct dx_mcap_group {
    uint8_t *bytes;
    size_t len, cap;
    uint32_t n;
};

struct dx_mcap_writer {
    struct dx_mcap_writer_config config; /* its texts are these copies */
    char profile[DX_MCAP_MAX_NAME + 1], library[DX_MCAP_MAX_NAME + 1];
    struct dx_mcap_sink sink;
    struct dx_mcap_packer *packer;
    struct dx_mcap_defs defs;

    /* the open chunk */
    uint8_t *chunk;
    size_t chunk_len, chunk_cap;
    uint64_t start, end; /* log times */
    struct dx_mcap_entry *entries;
    uint32_t n_entries;
    struct dx_mcap_list *lists; /* by order of channel */
    bool *schema_in_chunk;      /* by order of schema */
    uint8_t *packed;
    size_t packed_cap;

    /* the file up to its last whole piece */
    uint64_t file_len;
    uint32_t file_crc;
    struct dx_mcap_group chunks, attachments, metadata;
    struct dx_mcap_statistics stats;

    uint8_t stage[DX_MCAP_STAGE];
};

/*
 * Bytes being appended behind the last whole piece: gathered in the stage, then written. What was
 * put counts only when commit() has returned 0. A failed piece stays failed.
 */
struct dx_mcap_piece {
    struct dx_mcap_writer *w;
    uint64_t at; /* where the stage goes */
    size_t staged;
    uint32_t crc; /* of all up to here */
    int failed;
};

struct dx_mcap_piece dx_mcap_piece_begin(struct dx_mcap_writer *w);
void dx_mcap_piece_put(struct dx_mcap_piece *p, const void *bytes, size_t len);
/* Where the next byte goes. */
static inline uint64_t dx_mcap_piece_at(const struct dx_mcap_piece *p)
{
    return p->at + p->staged;
}
/* Writes what is staged; the file then ends here. */
int dx_mcap_piece_commit(struct dx_mcap_piece *p);

/* ---- for the writer and the repair ------------------------------------------------------------
 */

/* Notes a message of the open chunk for its index; there is room for max_messages. */
void dx_mcap_writer_note(struct dx_mcap_writer *w, const struct dx_mcap_def *channel,
                         uint64_t log_time, size_t offset);
/* Writes a chunk, the message indexes of what was noted, and counts them. The open chunk is then
 * empty. */
int dx_mcap_writer_put_chunk(struct dx_mcap_writer *w, const struct dx_mcap_chunk *chunk);
/* There is room in the index for one chunk more. */
bool dx_mcap_writer_has_room(const struct dx_mcap_writer *w);
void dx_mcap_writer_clear_chunk(struct dx_mcap_writer *w);

#endif
