/*
 * Requests of the control socket about one stream:
 * {"request":"record","do":"start"|"stop"|"status"} and
 * {"request":"replay","do":"pause"|"resume"|"seek"|"rate"|"step"|"status"}, with "stream" where
 * there are several, and "seconds", "rate", "frames". Loop thread.
 */
#ifndef DX_CONTROL_STREAM_H
#define DX_CONTROL_STREAM_H

#include <jansson.h>

struct dx_server;
struct dx_server_stream;

/* What the request is answered with: the state after it, or {"error":...}. NULL: no memory. */
json_t *dx_control_record(struct dx_server *server, const json_t *request);
json_t *dx_control_replay(struct dx_server *server, const json_t *request);

/* The same states for status; NULL: the stream is not recorded, or replays no recording. */
json_t *dx_control_recording(const struct dx_server_stream *st);
json_t *dx_control_replaying(const struct dx_server_stream *st);

#endif
