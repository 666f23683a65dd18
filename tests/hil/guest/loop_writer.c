/*
 * loop_writer DEVICE FOURCC WxH FPS N: a depth camera through v4l2loopback: N frames of
 * depth_pattern(), so many a second. The kernel may hold it up for ever; the runner ends it.
 */
#include "tests/hil/depth_pattern.h"
#include "tests/hil/guest/video.h"

#include <time.h>

static uint16_t picture[1920 * 1080];

int main(int argc, char **argv)
{
    struct timespec due;
    uint32_t width, height;
    long period_ns, n;
    size_t len;
    int fd;

    if (argc != 6)
        die("usage: loop_writer DEVICE FOURCC WxH FPS N");
    fd = video_open(argv[1]);
    video_set_format(fd, V4L2_BUF_TYPE_VIDEO_OUTPUT, argv[2], argv[3], &width, &height);
    len = (size_t)width * height * 2;
    if (len > sizeof(picture))
        die("%s is too large", argv[3]);
    period_ns = 1000000000 / strtol(argv[4], NULL, 10);
    n = strtol(argv[5], NULL, 10);
    clock_gettime(CLOCK_MONOTONIC, &due);
    for (long frame = 0; frame < n; frame++) {
        for (uint32_t i = 0; i < width * height; i++)
            picture[i] = depth_pattern(i % width, i / width, (uint64_t)frame);
        if (write(fd, picture, len) != (ssize_t)len)
            die("%s: %s", argv[1], strerror(errno));
        due.tv_nsec += period_ns;
        if (due.tv_nsec >= 1000000000) {
            due.tv_nsec -= 1000000000;
            due.tv_sec++;
        }
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, NULL);
    }
    return 0;
}
