/*
 * Events that come in a queue for each line, in the order of their times: an event is given out
 * when every line has told its next one, or when none with an earlier time can come any more. Fed
 * with events; knows no clock. Owned by its encoder.
 */
#ifndef DX_EDGE_MERGE_H
#define DX_EDGE_MERGE_H

#include "drivers/gpio/gpio_port.h"

#define DX_EDGE_MERGE_LINES 3
#define DX_EDGE_MERGE_DEPTH 64 /* events of one line that can wait */

struct dx_edge_merge {
    uint32_t n_lines;
    struct {
        struct dx_gpio_event event[DX_EDGE_MERGE_DEPTH];
        uint32_t head, n;
    } line[DX_EDGE_MERGE_LINES];
    uint64_t last_ns; /* of the event given out last */
    uint32_t last_line;
};

struct dx_edge_merged {
    struct dx_gpio_event event[2];
    uint32_t n;   /* 2: of lines 0 and 1, at one time; their order is not known */
    bool is_late; /* it should, or may, have come before the one that was given out last */
};

void dx_edge_merge_init(struct dx_edge_merge *m, uint32_t n_lines);

/* False: the line's queue is full; pop first, if need be with horizon_ns UINT64_MAX. */
bool dx_edge_merge_push(struct dx_edge_merge *m, const struct dx_gpio_event *event);

/* The next event, or two. No line will tell of one before `horizon_ns` any more. False: none yet.
 */
bool dx_edge_merge_pop(struct dx_edge_merge *m, uint64_t horizon_ns, struct dx_edge_merged *out);

/* Does something wait for its turn? */
bool dx_edge_merge_waits(const struct dx_edge_merge *m);

#endif
