/*
 * The metrics as a file, for the textfile collector of node_exporter: written anew every so many
 * seconds, beside itself and renamed, so that who reads it sees all of one moment. The loop gathers
 * the status and hands it over; a thread of its own makes text of it and writes, so that a disk
 * that is slow, full or stuck holds up nobody. While one is written the newest waits, and those
 * before it are left out.
 */
#ifndef DX_METRICS_FILE_H
#define DX_METRICS_FILE_H

#include "core/base/err.h"

#include <stdint.h>

struct dx_metrics_file;
struct dx_server;

/* Starts the thread; `path` is copied. Errors, with text: -ENOMEM, -ENAMETOOLONG, those of
 * pthread_create. */
int dx_metrics_file_new(struct dx_metrics_file **out, const char *path, uint32_t period_s,
                        struct dx_err *err);

/* Ends the thread and removes the file: what is not running has no metrics. NULL is fine. */
void dx_metrics_file_free(struct dx_metrics_file *f);

/* The loop, now and then: takes the status when it is due. NULL is fine. */
void dx_metrics_file_tick(struct dx_metrics_file *f, const struct dx_server *server,
                          uint64_t now_ns);

#endif
