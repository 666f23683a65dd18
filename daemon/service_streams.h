/* The streams that a service has, and how one is shown to its server. */
#ifndef DX_SERVICE_STREAMS_H
#define DX_SERVICE_STREAMS_H

#include "daemon/server.h"
#include "daemon/stream.h"

struct dx_stream_list {
    struct dx_stream *stream[DX_CONFIG_MAX_STREAMS];
    uint32_t n;
};

struct dx_stream *dx_stream_list_find(const struct dx_stream_list *list, const char *name);
void dx_stream_list_add(struct dx_stream_list *list, struct dx_stream *s); /* there is room */
void dx_stream_list_remove(struct dx_stream_list *list, const struct dx_stream *s);

/* Joins what can be joined before `due_ns`, and frees that; the others stay. True: none does. */
bool dx_stream_list_end(struct dx_stream_list *list, uint64_t due_ns);

/* What the server must know of it; all of it lives as long as the stream. */
struct dx_server_stream_options dx_service_shows(struct dx_stream *s);

/* Puts before the text which stream of `file` it is about; without a file (NULL) there is one, and
 * it has no name that anybody gave. */
void dx_service_blame(struct dx_err *err, const char *file, const struct dx_stream_config *c);

/* The bounds of a configuration. */
struct dx_server_limits dx_service_limits(const struct dx_config *c);

#endif
