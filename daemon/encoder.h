/*
 * Encodes tiles for the feed: windows of tiles over the pool, each in the forms that owe it,
 * added to the open epoch in the order of their numbers. Owned by one mesher; allocates nothing
 * after new.
 */
#ifndef DX_ENCODER_H
#define DX_ENCODER_H

#include "core/grid/lod.h"
#include "daemon/feed.h"

struct dx_encoder;

/* Errors: -ENOMEM. */
int dx_encoder_new(struct dx_encoder **out, struct dx_pool *pool);
void dx_encoder_free(struct dx_encoder *e); /* NULL is fine */

/* Where meshes come from: levels of detail too, when a form of theirs is pending. */
struct dx_encoder_source {
    const struct dx_terrain *terrain;
    const struct dx_lod *lod;
    struct dx_lod_level level[DX_LOD_SLOTS];
};

/* Adds every tile with its bit in pending[form] to the feed's open epoch. False: short of chunks.
 */
bool dx_encoder_add(struct dx_encoder *e, struct dx_feed *feed,
                    const struct dx_encoder_source *source, uint64_t *const pending[DX_N_FORMS]);

#endif
