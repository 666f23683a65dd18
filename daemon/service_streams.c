/* A list of streams, in the order of their coming. Its owner's thread. */
#include "daemon/service_streams.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

struct dx_stream *dx_stream_list_find(const struct dx_stream_list *list, const char *name)
{
    for (uint32_t k = 0; k < list->n; k++)
        if (!strcmp(dx_stream_config(list->stream[k])->name, name))
            return list->stream[k];
    return NULL;
}

void dx_stream_list_add(struct dx_stream_list *list, struct dx_stream *s)
{
    assert(list->n < DX_CONFIG_MAX_STREAMS);
    list->stream[list->n++] = s;
}

void dx_stream_list_remove(struct dx_stream_list *list, const struct dx_stream *s)
{
    uint32_t n = 0;

    for (uint32_t k = 0; k < list->n; k++)
        if (list->stream[k] != s)
            list->stream[n++] = list->stream[k];
    list->n = n;
}

bool dx_stream_list_end(struct dx_stream_list *list, uint64_t due_ns)
{
    uint32_t n = 0;

    for (uint32_t k = 0; k < list->n; k++) {
        if (dx_stream_join(list->stream[k], due_ns))
            dx_stream_free(list->stream[k]);
        else
            list->stream[n++] = list->stream[k];
    }
    list->n = n;
    return n == 0;
}

struct dx_server_stream_options dx_service_shows(struct dx_stream *s)
{
    const struct dx_stream_config *c = dx_stream_config(s);

    return (struct dx_server_stream_options){.name = c->name,
                                             .feed = dx_stream_feed(s),
                                             .counters = dx_stream_counters(s),
                                             .lossless = c->lossless,
                                             .recorder = dx_stream_recorder(s),
                                             .player = dx_stream_player(s),
                                             .reader = dx_stream_reader(s),
                                             .beats = dx_stream_beats(s),
                                             .subscribers = dx_stream_subscribers,
                                             .ctx = s};
}

void dx_service_blame(struct dx_err *err, const char *file, const struct dx_stream_config *c)
{
    char where[256];

    if (!file)
        return;
    snprintf(where, sizeof(where), "%.150s:%u: stream %s", file, c->line, c->name);
    dx_err_prefix(err, where);
}

struct dx_server_limits dx_service_limits(const struct dx_config *c)
{
    return (struct dx_server_limits){.max_clients = c->max_clients,
                                     .max_clients_per_uid = c->max_clients_per_uid,
                                     .client_memory = (uint64_t)c->client_memory_mib << 20,
                                     .max_requests = c->max_requests};
}
