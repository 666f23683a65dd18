/*
 * Where a stage really was: the counts of its encoder, and when they came. gpio_turn writes it, as
 * it pulls the lines, into a file that scip_sim maps: however late edges are on a busy machine, the
 * scanner sees the room from where the encoder says that it stands. One writer, any readers.
 */
#ifndef SCIP_TRACK_H
#define SCIP_TRACK_H

#include "core/base/trig.h"

#include <fcntl.h>
#include <stdatomic.h>
#include <stdint.h>
#include <sys/mman.h>
#include <unistd.h>

#define SCIP_TRACK_LEN 1024 /* counts that are remembered */

struct scip_track {
    uint64_t counts;   /* of a turn */
    uint64_t count_ns; /* between two of them, when none is late */
    _Atomic uint64_t n;
    struct {
        uint64_t count, host_ns;
    } at[SCIP_TRACK_LEN]; /* number k at k % SCIP_TRACK_LEN */
};

/* NULL: cannot be had, errno tells why. */
static inline struct scip_track *scip_track_map(const char *path, int flags)
{
    int fd = open(path, flags | O_CLOEXEC, 0600);
    void *p = MAP_FAILED;

    if (fd >= 0 && (!(flags & O_CREAT) || ftruncate(fd, sizeof(struct scip_track)) == 0))
        p = mmap(NULL, sizeof(struct scip_track),
                 flags & O_CREAT ? PROT_READ | PROT_WRITE : PROT_READ, MAP_SHARED, fd, 0);
    if (fd >= 0)
        close(fd);
    if (p == MAP_FAILED)
        return NULL;
    return p;
}

static inline void scip_track_put(struct scip_track *track, uint64_t count, uint64_t host_ns)
{
    uint64_t n = atomic_load_explicit(&track->n, memory_order_relaxed);

    track->at[n % SCIP_TRACK_LEN].count = count;
    track->at[n % SCIP_TRACK_LEN].host_ns = host_ns;
    atomic_store_explicit(&track->n, n + 1, memory_order_release);
}

/* The stage's angle: even between two counts; after the last one on at its speed, up to the next.
 */
static inline double scip_track_stage(const struct scip_track *track, uint64_t host_ns)
{
    uint64_t n = atomic_load_explicit(&track->n, memory_order_acquire), k = n;
    uint64_t oldest = n > SCIP_TRACK_LEN / 2 ? n - SCIP_TRACK_LEN / 2 : 0, begin_ns, len_ns;
    double part;

    while (k > oldest + 1 && track->at[(k - 1) % SCIP_TRACK_LEN].host_ns > host_ns)
        k--;
    if (k == 0)
        return 0;
    begin_ns = track->at[(k - 1) % SCIP_TRACK_LEN].host_ns;
    len_ns = k < n ? track->at[k % SCIP_TRACK_LEN].host_ns - begin_ns : track->count_ns;
    part = host_ns > begin_ns && len_ns ? (double)(host_ns - begin_ns) / (double)len_ns : 0;
    return 2 * DX_PI / (double)track->counts *
           ((double)(track->at[(k - 1) % SCIP_TRACK_LEN].count % track->counts) +
            (part < 1 ? part : 1));
}

#endif
