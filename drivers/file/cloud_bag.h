/*
 * An MCAP file of another program as a source of scans: the PointCloud2 messages of one topic, in
 * the order of their log times or of the file. Owned by one thread.
 */
#ifndef DX_CLOUD_BAG_H
#define DX_CLOUD_BAG_H

#include "drivers/file/mcap_read.h"

struct dx_cloud_bag;

/* Is the file MCAP? */
bool dx_cloud_bag_probe(const char *path);

/* `topic` NULL or "": the only one with clouds. Errors: -EBADMSG (no MCAP, no such topic, several
 * of them), -ENOMEM, from open; err names the file. */
int dx_cloud_bag_open(struct dx_cloud_bag **out, const char *path, const char *topic,
                      enum dx_mcap_order order, struct dx_err *err);
void dx_cloud_bag_close(struct dx_cloud_bag *bag);

/* Does the file have a topic with clouds? */
bool dx_cloud_bag_has_clouds(const struct dx_mcap_reader *reader);

/* The next message; its bytes hold until the next call. 0; DX_MCAP_E_END; negative with err, which
 * names the file: also in place of the end, when some of it is damaged. */
int dx_cloud_bag_next(struct dx_cloud_bag *bag, struct dx_mcap_message *out, struct dx_err *err);

#endif
