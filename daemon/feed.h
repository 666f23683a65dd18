/*
 * The feed of one stream: the only thing that the mesher and the loop thread share about meshes.
 *
 * Chunks live in a fixed arena of blocks. The mesher owns the free ones: it takes some, fills them,
 * and publishes an epoch through a single-producer ring. The loop thread owns everything published:
 * the current chunk of each tile and encoding, the reference counts, the clients' pins. A chunk
 * that nobody holds any more goes home through a second ring. No lock, no wait: a mesher that is
 * short of chunks raises a request that the loop answers by revoking the oldest pin, keeps its own
 * list of unsent tiles, and publishes them with a later epoch.
 *
 * This half is called by the mesher thread alone; feed_loop.h is the loop thread's half.
 */
#ifndef DX_FEED_H
#define DX_FEED_H

#include "core/grid/lod.h"
#include "core/wire/chunk.h"
#include "daemon/passage.h"

struct dx_feed;

/* What tiles are told in: the whole mesh in each encoding, then levels of detail in f32. A form
 * below DX_N_ENCODINGS is an enum dx_encoding. Which level a form is, the loop says. */
#define DX_N_FORMS (DX_N_ENCODINGS + DX_LOD_SLOTS)

static inline enum dx_encoding dx_form_encoding(unsigned form)
{
    return form < DX_N_ENCODINGS ? (enum dx_encoding)form : DX_ENCODING_F32;
}

/*
 * Memory for `max_tiles` tiles: room for `n_epochs` (6: one current, one being built, four pinned)
 * full frames in each form, but address space only until it is used, and no more of it than the
 * grid in force needs. `wake_fd` (a non-blocking eventfd; -1: the feed makes its own) is written
 * when there is something for the loop. `kick` is called by the loop when the mesher should look
 * again (forms wanted, chunks came home); it must not block. Errors: -ENOMEM.
 */
int dx_feed_new(struct dx_feed **out, uint32_t max_tiles, uint32_t n_epochs, uint8_t attr_bytes,
                int wake_fd, void (*kick)(void *ctx), void *kick_ctx);
void dx_feed_free(struct dx_feed *f); /* after both threads have let go */

/*
 * Takes back what came home and publishes what had to wait; to be called whenever kicked.
 * Which forms somebody wants: generation per form, 0 = nobody. A generation the mesher has
 * not served yet asks for all tiles, not only changed ones.
 */
void dx_feed_wanted(struct dx_feed *f, uint32_t generation[DX_N_FORMS]);

/* The level of form DX_N_ENCODINGS + slot, to be asked after dx_feed_wanted: when it has moved on
 * since, what is made for the older generation is dropped unseen. */
struct dx_lod_level dx_feed_level(const struct dx_feed *f, unsigned slot);

/* Starts an epoch; they are numbered from 1, upwards. `generation`: what dx_feed_wanted said. */
void dx_feed_begin(struct dx_feed *f, uint64_t epoch, const uint32_t generation[DX_N_FORMS]);

/* Adds a chunk for a tile (a TILE body of `len` bytes) to the open epoch; `len` of
 * DX_CHUNK_HEADER_LEN: the tile is empty. False: short of chunks; the mesher must call
 * dx_feed_abort and try again when kicked. */
bool dx_feed_add(struct dx_feed *f, uint32_t tile, unsigned form, size_t len, uint32_t *chunk);

/* Its bytes: before the epoch is committed, on any thread that the mesher waits for. */
void dx_feed_fill(struct dx_feed *f, uint32_t chunk, const uint8_t *body);

/* Publishes the epoch. Always succeeds. `passage` NULL: no new data came with it. */
void dx_feed_commit(struct dx_feed *f, const struct dx_msg_commit *commit,
                    const struct dx_passage *passage);

/* Takes back all that was added since begin; asks the loop to revoke the oldest pin. */
void dx_feed_abort(struct dx_feed *f);

/* RESET with a new geometry (the feed takes a reference) and parameters in force, before the first
 * epoch of it. All tiles of before are gone; generations start anew. */
void dx_feed_reset(struct dx_feed *f, struct dx_geometry *g, const struct dx_terrain_params *params,
                   uint8_t attr_bytes, const char *reason);

void dx_feed_state(struct dx_feed *f, enum dx_stream_state state, const char *reason);

/*
 * Lossless replay: newest epoch that every lossless subscriber has been sent whole; UINT64_MAX when
 * there is none. The mesher may wait for it (only then), and is kicked when it moves. An epoch for
 * a new generation must not wait: a lossless subscriber who has nothing yet counts as 0.
 */
uint64_t dx_feed_lossless_epoch(const struct dx_feed *f);

#endif
