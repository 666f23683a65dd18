/*
 * A stream: one configured source with everything it owns (device, mailbox, feed, mesher, counters)
 * and its two threads. Made and ended by one thread at a time: the main thread, or a reload beside
 * the loop (reload.h).
 */
#ifndef DX_STREAM_H
#define DX_STREAM_H

#include "core/base/err.h"
#include "core/base/pool.h"
#include "daemon/config.h"
#include "daemon/counters.h"
#include "daemon/feed.h"
#include "daemon/recorder.h"

struct dx_heartbeats;
struct dx_stream;
struct dx_stream_reader;

/* A grid may have so many tiles (4096 cells each). A stream's feed has room for them: address
 * space, not memory. */
extern const uint32_t dx_stream_max_tiles;

/* Opens the source and allocates all that the frame path will use. `config` is copied, `pool`
 * borrowed. Errors name the source; dx_service_blame tells whose it is. */
int dx_stream_new(struct dx_stream **out, const struct dx_stream_config *config,
                  struct dx_pool *pool, struct dx_err *err);

/* NULL is fine. Its threads must not run (never started, or joined), and the loop must have let go
 * of the feed. */
void dx_stream_free(struct dx_stream *s);

/* Starts the threads. Errors: -EAGAIN and such from pthread_create; subscribers are told, too. */
int dx_stream_start(struct dx_stream *s, struct dx_err *err);
bool dx_stream_is_started(const struct dx_stream *s);

/* Asks the threads to stop; dx_stream_join waits for them. False: the reader did not come back
 * before `due_ns` of CLOCK_MONOTONIC (a decode cannot be interrupted), or the recorder not in 2 s
 * more (a disk that is stuck), and nothing of the stream may be freed. */
void dx_stream_stop(struct dx_stream *s);
bool dx_stream_join(struct dx_stream *s, uint64_t due_ns);

/* How many have subscribed; a replay that waits for some starts when there are enough. Any thread.
 */
void dx_stream_subscribers(void *stream, uint32_t n);

/* For the loop: what presence pokes, and the state of a device. */
struct dx_stream_reader *dx_stream_reader(struct dx_stream *s);

/* NULL: nothing of it is recorded. */
struct dx_recorder *dx_stream_recorder(struct dx_stream *s);
/* The player (player.h) of a stream that replays a recording; else NULL. */
struct dx_device *dx_stream_player(struct dx_stream *s);

/* Of its threads. */
const struct dx_heartbeats *dx_stream_beats(const struct dx_stream *s);

struct dx_feed *dx_stream_feed(struct dx_stream *s);
struct dx_counters *dx_stream_counters(struct dx_stream *s);
const struct dx_stream_config *dx_stream_config(const struct dx_stream *s);

#endif
