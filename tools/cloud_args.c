/* Frames, topics and viewpoints. */
#include "tools/cloud_args.h"

#include "tools/source.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

int dx_cloud_arg_frame(struct dx_cloud_source *source, const struct dx_arg *arg)
{
    if (strcmp(arg->text, "all") == 0) {
        source->frame = DX_CLOUD_READ_ALL;
        return 0;
    }
    return dx_arg_u64(&source->frame, arg, 0, 1000000000, "all, or a frame's number");
}

int dx_cloud_arg_viewpoint(double viewpoint[3], const struct dx_arg *arg)
{
    const int n = dx_arg_triple(viewpoint, arg, -1e12, 1e12, "coordinates");

    if (n >= 0 && n != 3)
        return dx_arg_bad(arg, "three coordinates with commas between");
    return n < 0 ? n : 0;
}

int dx_cloud_arg_check(const struct dx_cloud_source *source, const char *command)
{
    const struct dx_file_config config = {
        .path = source->path, .topic = source->topic, .fit.seam = -1};

    if (dx_cloud_source_has_frames(source->path))
        return dx_source_check(&config, command);
    if (source->frame == DX_CLOUD_READ_LAST && !source->topic)
        return 0;
    fprintf(stderr, "%s: %s: found the file '%s', expected a recording, MCAP, a folder or a glob\n",
            command, source->topic ? "--topic" : "--frame", source->path);
    return -EINVAL;
}
