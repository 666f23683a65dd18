/* What {"request":"status"} is answered with. Loop thread. */
#ifndef DX_STATUS_H
#define DX_STATUS_H

#include <jansson.h>
#include <stdbool.h>

struct dx_server;
struct dx_subscriber;

/*
 * {"version", "time_s", "uptime_s", "rss_bytes", "cpu_s", "fds", "max_fds", "connections",
 * "streams": [{name, state, reason, geometry, width, height, frames, parts, fps, epochs,
 * tiles_changed, tiles_same, tiles_sent, drops: {mailbox, corrupt}, short_of_chunks, valid,
 * mesh_ms, mesh_s, mesh_ns_per_dexel, sigma, lag_s, subscribers, slow, hangs: {reader, mesher,
 * recorder}, latency_ms: {p50, p99, stages: {decode: {p50, p99}, wait, mesh, encode, send}},
 * device: {state, since_s, reason, serial, place, trouble, opens, lost, damaged, stalls, faults,
 * unplugged}, recording, replay}], "clients": [{number, pid, uid, stream, encoding, mode, epochs,
 * coalesced, resets, bytes, lag_s}]}; what is not known is not there. NULL: no memory.
 *
 * `histograms`: latencies have as well {"sum_s", "within": [as dx_latency_bounds, and above]}.
 */
json_t *dx_status(const struct dx_server *server, bool histograms);

/* One of the clients. */
json_t *dx_status_client(const struct dx_subscriber *s);

#endif
