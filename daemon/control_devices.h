/*
 * {"request":"devices"}: what is attached that a driver of this build would take, as the service
 * sees it: with its permissions, and beside the streams that have some of it open. Drivers are
 * asked by a thread of their own, for a device may take its time; the loop has the answer later.
 * One asking at a time: who asks meanwhile gets the same answer. Loop thread.
 */
#ifndef DX_CONTROL_DEVICES_H
#define DX_CONTROL_DEVICES_H

#include <jansson.h>
#include <stdint.h>

struct dx_probe;
struct dx_server;

/* `done` is called by the loop when there is an answer: {"devices":[...]}, which is the callee's to
 * keep. Errors: -ENOMEM, -errno. */
int dx_probe_new(struct dx_probe **out, struct dx_server *server,
                 void (*done)(void *ctx, json_t *answer), void *ctx);
/* A thread that still asks is left to itself. */
void dx_probe_free(struct dx_probe *p);

#define DX_CONTROL_DEVICES 1 /* the number of every asking */

/* DX_CONTROL_DEVICES: drivers are being asked; 0: they cannot, and dx_control_no_devices says why.
 */
uint64_t dx_control_begin_devices(struct dx_server *server);
json_t *dx_control_no_devices(struct dx_server *server, const json_t *request);

#endif
