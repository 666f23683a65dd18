/*
 * The control requests about the configuration. {"request":"config"} is answered with
 * {"yaml":TEXT}, what is in force, and where each value is from. {"request":"reload"}: the
 * configuration is read again, and the answer comes when that is done: "file"; "added", "changed",
 * "removed" and "unchanged", arrays of the names of streams; "restart", an array of keys whose new
 * values count from the next start on; "trouble", a text, when something went wrong all the same.
 * Refused: {"error":...}. Loop thread.
 */
#ifndef DX_CONTROL_CONFIG_H
#define DX_CONTROL_CONFIG_H

#include <jansson.h>
#include <stdint.h>

struct dx_reload_report;
struct dx_server;

json_t *dx_control_config(struct dx_server *server, const json_t *request);

/* Its number; 0: none can begin. Not while another one waits for a source, which may be for ever.
 */
uint64_t dx_control_begin_reload(struct dx_server *server);

/* Why no reload can begin. */
json_t *dx_control_no_reload(struct dx_server *server, const json_t *request);

/* Reload `number` is done: answers those who wait for it. */
void dx_control_reloaded(struct dx_server *server, uint64_t number,
                         const struct dx_reload_report *report);

#endif
