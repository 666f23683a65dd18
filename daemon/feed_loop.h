/*
 * The loop thread's half of a feed: adopts what the mesher published, holds the current chunk of
 * each tile and form, counts references, and takes pins back when the mesher is short of
 * chunks. view.h is one subscriber's place in it. All of it belongs to the loop thread.
 */
#ifndef DX_FEED_LOOP_H
#define DX_FEED_LOOP_H

#include "daemon/feed_priv.h"

#define DX_FEED_MAX_PINS 4u /* distinct epochs older than the newest */
#define DX_FEED_PIN_GRACE_NS                                                                       \
    2000000000u                       /* after this a pin gives way to a view that waits for one */
#define DX_FEED_LINGER_NS 2000000000u /* a form stays wanted so long after its last view */

/* What dx_feed_loop_turn found. */
#define DX_FEED_NEW_EPOCH 0x1u
#define DX_FEED_NEW_RESET 0x2u
#define DX_FEED_NEW_STATE 0x4u

struct dx_view;

/* Views in a batch of one epoch that still hold chunks. */
struct dx_feed_pin {
    uint64_t seq;
    uint64_t since_ns;
    uint32_t n_views;
};

struct dx_feed_loop {
    struct dx_feed *feed;

    /* as of the newest RESET; geometry is NULL before the first */
    struct dx_geometry *geometry;
    struct dx_tiling tiling;
    struct dx_terrain_params params;
    uint8_t attr_bytes;
    char reset_reason[DX_WIRE_TEXT];

    enum dx_stream_state state;
    char state_reason[DX_WIRE_TEXT];

    /* the newest adopted epoch */
    uint64_t seq; /* counts adoptions, whatever numbers the mesher gives its epochs */
    uint64_t epoch;
    struct dx_msg_commit commit;
    struct dx_passage passage;
    bool has_epoch; /* one was adopted since the newest RESET */

    /* per form */
    uint32_t generation[DX_N_FORMS]; /* wanted; 0 = nobody */
    uint32_t last_generation[DX_N_FORMS];
    uint32_t n_views[DX_N_FORMS];
    uint64_t unused_since_ns[DX_N_FORMS];
    bool whole[DX_N_FORMS];        /* `current` is all of the newest epoch */
    uint32_t *current[DX_N_FORMS]; /* chunk of each tile; NONE: empty */

    struct dx_lod_level level[DX_LOD_SLOTS]; /* of the forms after the encodings */

    struct dx_view *views;
    struct dx_feed_pin pin[DX_FEED_MAX_PINS + 1]; /* oldest first */
    uint32_t n_pins;
    uint32_t n_home; /* things sent home since the last kick */
};

/* Errors: -ENOMEM. The feed must live longer. */
int dx_feed_loop_new(struct dx_feed_loop **out, struct dx_feed *f);
void dx_feed_loop_free(struct dx_feed_loop *l); /* after its views have left */

/*
 * Adopts what was published, then answers the mesher's request for chunks. While a lossless view
 * has not got the newest epoch whole, no further epoch is adopted. Returns DX_FEED_NEW_* bits.
 */
unsigned dx_feed_loop_turn(struct dx_feed_loop *l);

/* After views were served: publishes the lossless epoch, kicks a mesher that waits for chunks.
 * True: something can be adopted now that could not before; take another turn. */
bool dx_feed_loop_settle(struct dx_feed_loop *l);

/* Drops forms whose last view left DX_FEED_LINGER_NS ago. */
void dx_feed_loop_expire(struct dx_feed_loop *l, uint64_t now_ns);

/* For view.c: one reference fewer; at none the chunk goes home. NONE is fine. */
void dx_feed_loop_unref(struct dx_feed_loop *l, uint32_t chunk);
void dx_feed_loop_unpin(struct dx_feed_loop *l, uint64_t seq);
/* Takes the oldest pin back, unless it is of the newest epoch. */
bool dx_feed_loop_revoke_oldest(struct dx_feed_loop *l);
void dx_feed_loop_want(struct dx_feed_loop *l, unsigned form);

/* The form of a level of detail (not the whole mesh), for a view that joins next: one that others
 * have, or a free one. DX_N_FORMS: all are of other levels, and in use. */
unsigned dx_feed_loop_form(struct dx_feed_loop *l, struct dx_lod_level level);

#endif
