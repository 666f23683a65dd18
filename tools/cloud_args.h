/* What all commands that read unorganized points are asked alike: which frame, from where. Each
 * says on standard error what it refuses. */
#ifndef DX_CLOUD_ARGS_H
#define DX_CLOUD_ARGS_H

#include "tools/args.h"
#include "tools/cloud_read.h"

/* A frame's number or "all"; three coordinates. 0 or -EINVAL. */
int dx_cloud_arg_frame(struct dx_cloud_source *source, const struct dx_arg *arg);
int dx_cloud_arg_viewpoint(double viewpoint[3], const struct dx_arg *arg);

/* A frame can be told of what has frames alone, and MCAP alone has topics. 0 or -EINVAL. */
int dx_cloud_arg_check(const struct dx_cloud_source *source, const char *command);

#endif
