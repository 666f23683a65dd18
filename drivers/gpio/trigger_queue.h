/*
 * Edges of a trigger line and the frames that belong to them: the n-th frame to the n-th edge, as
 * long as that fits. A frame comes some time after its edge (exposure, read-out, transfer), always
 * about the same; when it does not, an edge or a frame was lost, and the pairs are sought anew.
 * Pure; owned by its rig.
 */
#ifndef DX_TRIGGER_QUEUE_H
#define DX_TRIGGER_QUEUE_H

#include <stdbool.h>
#include <stdint.h>

#define DX_TRIGGER_QUEUE_LEN 256u /* edges that wait: a power of two */

struct dx_trigger_queue {
    uint64_t max_delay_ns; /* a frame comes no later than this after its edge */
    uint64_t edge_ns[DX_TRIGGER_QUEUE_LEN];
    uint64_t n_edges, next;           /* put in; the first that has no frame yet */
    uint64_t last_edge_ns, period_ns; /* 0: not known */
    uint32_t n_long;                  /* gaps in a row that are longer than the period */
    bool is_paired;                   /* delay_ns is that of the frame before */
    uint64_t delay_ns;                /* from edge to frame, smoothed */
    uint64_t n_frames, n_pairs, n_resyncs, n_glitches;
};

void dx_trigger_queue_init(struct dx_trigger_queue *q, uint64_t max_delay_ns);

/* The source starts anew: edges that wait belong to nothing. */
void dx_trigger_queue_restart(struct dx_trigger_queue *q);

/* An edge. One within `min_gap_ns` of the one before is a glitch and left out. `doubt`: edges
 * before it may be missing. */
void dx_trigger_queue_edge(struct dx_trigger_queue *q, uint64_t t_ns, uint64_t min_gap_ns,
                           bool doubt);

/* A frame that came at `arrival_ns`, behind n_missed that never came. True: *edge_ns is its edge.
 */
bool dx_trigger_queue_frame(struct dx_trigger_queue *q, uint64_t arrival_ns, uint64_t n_missed,
                            uint64_t *edge_ns);

#endif
