/*
 * video_set DEVICE NAME VALUE [NAME VALUE]...: sets controls of a V4L2 device by their names ("Test
 * Pattern"; any case), a button by any value. `video_set DEVICE` lists them.
 */
#include "tests/hil/guest/video.h"

#include <strings.h>

/* 0 at the end of the list. */
static int next_control(int fd, struct v4l2_query_ext_ctrl *q)
{
    q->id |= V4L2_CTRL_FLAG_NEXT_CTRL;
    return video_ioctl(fd, VIDIOC_QUERY_EXT_CTRL, q) == 0;
}

static void list(int fd)
{
    struct v4l2_query_ext_ctrl q = {0};

    while (next_control(fd, &q))
        printf("%s: %lld to %lld, preset %lld\n", q.name, (long long)q.minimum,
               (long long)q.maximum, (long long)q.default_value);
}

static void set(int fd, const char *name, const char *value)
{
    struct v4l2_query_ext_ctrl q = {0};
    struct v4l2_control c;
    int r;

    while (next_control(fd, &q) && strcasecmp(q.name, name) != 0)
        ;
    if (strcasecmp(q.name, name) != 0)
        die("no control '%s'", name);
    c.id = q.id;
    c.value = (int)strtol(value, NULL, 0);
    r = video_ioctl(fd, VIDIOC_S_CTRL, &c);
    if (r < 0)
        die("%s = %s: %s", name, value, strerror(-r));
}

int main(int argc, char **argv)
{
    int fd;

    if (argc < 2 || argc % 2)
        die("usage: video_set DEVICE [NAME VALUE]...");
    fd = video_open(argv[1]);
    if (argc == 2)
        list(fd);
    for (int i = 2; i < argc; i += 2)
        set(fd, argv[i], argv[i + 1]);
    return 0;
}
