/*
 * The configuration read again while the service runs. What takes time (reading the file, opening
 * sources, waiting for threads to end) is done beside the loop, what the loop must do between two
 * events is short:
 *
 *   beside   the file is read and compared, new and changed streams are opened: all of them, or it
 *            is refused and nothing has changed
 *   loop     the new streams take the places of the old ones, whose threads are told to stop
 *   beside   those are joined and freed; then the new ones start
 *   loop     what was done is told
 *
 * Owned by the service. Loop thread, but for dx_reload_end.
 */
#ifndef DX_RELOAD_H
#define DX_RELOAD_H

#include "core/base/pool.h"
#include "daemon/config.h"
#include "daemon/server.h"
#include "daemon/service_streams.h"

struct dx_reload;

/* All of it is borrowed, and changed by a reload between two events: `config` is what is in force,
 * `streams` are those that are served. */
struct dx_reload_options {
    const char *file;
    struct dx_server *server;
    struct dx_pool *pool;
    struct dx_config *config;
    struct dx_stream_list *streams;
};

/* -ENOMEM, -errno. */
int dx_reload_new(struct dx_reload **out, const struct dx_reload_options *options);

/* Starts one, or when one is under way another after it. Its number, from 1: that is what
 * dx_control_reloaded (control_config.h) answers. */
uint64_t dx_reload_ask(void *reload);

/* Is one under way that has been opening sources for long? Then which stream's just now. Another
 * one that is asked for would wait for as long. */
bool dx_reload_waits(struct dx_reload *r, char stream[64]);

/* When the loop has ended: waits for what is under way. The streams that it had in hand are then in
 * the list, and told to stop; those of before that could not be joined have been tried again.
 * False: something did not end before `due_ns` (a recorder: 2 s more), and what it uses must
 * stay. */
bool dx_reload_end(struct dx_reload *r, uint64_t due_ns);
void dx_reload_free(struct dx_reload *r); /* after dx_reload_end was true. NULL is fine */

#endif
