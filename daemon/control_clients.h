/*
 * Who is connected to the mesh socket, and ending one of them: {"request":"clients"}, with
 * "do":"disconnect" and "number" or "pid". Loop thread.
 */
#ifndef DX_CONTROL_CLIENTS_H
#define DX_CONTROL_CLIENTS_H

#include <jansson.h>

struct dx_server;

/* The clients as status tells them; or {"disconnected":N}, those that were told ERROR and are being
 * closed. NULL: no memory. */
json_t *dx_control_clients(struct dx_server *server, const json_t *request);

#endif
