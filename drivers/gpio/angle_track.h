/*
 * Where an encoder stood at any moment that is not too long ago, in counts. At an edge it stands
 * between two counts: at the upper one of them, whichever way it turns. Pure; owned by its encoder,
 * one thread at a time.
 */
#ifndef DX_ANGLE_TRACK_H
#define DX_ANGLE_TRACK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DX_ANGLE_TRACK_LEN   16384u /* edges that are kept: a power of two */
#define DX_ANGLE_TRACK_AHEAD 2      /* edge periods that a motion is continued without an edge */

struct dx_track_point {
    uint64_t host_ns;
    double counts;
    bool is_uncertain;
};

struct dx_angle_track {
    uint64_t n;            /* edges put in; the last DX_ANGLE_TRACK_LEN are there */
    uint64_t known_ns;     /* no edge before it can come any more */
    uint64_t certain_from; /* the number of the edge at the last index */
    struct dx_track_point edge[DX_ANGLE_TRACK_LEN];
};

/* Begins where it stands. */
void dx_angle_track_init(struct dx_angle_track *t, uint64_t host_ns, double counts,
                         bool is_uncertain);

/* An edge. A time before the last one is taken as the last one. */
void dx_angle_track_put(struct dx_angle_track *t, uint64_t host_ns, double counts,
                        bool is_uncertain);

/* The index is passed; `was_wrong`: what was counted since the last one, or from the start, is not
 * to be trusted. Call it before the put() of the index. */
void dx_angle_track_index(struct dx_angle_track *t, bool was_wrong);

/* All edges before this time have been put in. */
void dx_angle_track_know(struct dx_angle_track *t, uint64_t host_ns);

/*
 * Where it stood at a time: between two edges evenly from one to the next; behind the last
 * edge on at the speed of the last two, for at most two of their periods, and for no more than one
 * count when it is known that no edge has come. Uncertain beside uncertain edges, before the first
 * one kept, and farther ahead than that.
 */
struct dx_track_point dx_angle_track_at(const struct dx_angle_track *t, uint64_t host_ns);

/* The points that tell where it stood from `from_ns` to `until_ns`: these two, and between them
 * edges, evenly thinned out to `max` (2 at the least) in all. Returns how many. */
size_t dx_angle_track_points(const struct dx_angle_track *t, uint64_t from_ns, uint64_t until_ns,
                             struct dx_track_point *out, size_t max);

#endif
