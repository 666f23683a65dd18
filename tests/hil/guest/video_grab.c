/*
 * video_grab DEVICE FOURCC WxH N [FILE]: streams N frames of 16-bit pixels through mmap, as plainly
 * as it can be done, and prints what the kernel gave: a second opinion beside dexeld's driver. With
 * FILE the last frame's bytes go there; without, each must be depth_pattern() of one frame.
 */
#include "tests/hil/depth_pattern.h"
#include "tests/hil/guest/video.h"

#include <poll.h>
#include <sys/mman.h>

#define N_BUFFERS 8
#define WAIT_MS   10000

static struct {
    int fd;
    uint32_t width, height, n_buffers;
    void *memory[N_BUFFERS];
    size_t len[N_BUFFERS];
    uint16_t *pattern; /* of frame 0 */
    unsigned n_gaps, n_picture_gaps, n_errors;
} video;

static void check(int r, const char *what)
{
    if (r < 0)
        die("%s: %s", what, strerror(-r));
}

static void start(void)
{
    struct v4l2_requestbuffers request = {
        .count = N_BUFFERS, .type = V4L2_BUF_TYPE_VIDEO_CAPTURE, .memory = V4L2_MEMORY_MMAP};
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;

    check(video_ioctl(video.fd, VIDIOC_REQBUFS, &request), "VIDIOC_REQBUFS");
    video.n_buffers = request.count < N_BUFFERS ? request.count : N_BUFFERS;
    for (uint32_t i = 0; i < video.n_buffers; i++) {
        struct v4l2_buffer b = {.index = i, .type = request.type, .memory = request.memory};

        check(video_ioctl(video.fd, VIDIOC_QUERYBUF, &b), "VIDIOC_QUERYBUF");
        video.len[i] = b.length;
        video.memory[i] = mmap(NULL, b.length, PROT_READ, MAP_SHARED, video.fd, b.m.offset);
        if (video.memory[i] == MAP_FAILED)
            die("mmap: %s", strerror(errno));
        check(video_ioctl(video.fd, VIDIOC_QBUF, &b), "VIDIOC_QBUF");
    }
    check(video_ioctl(video.fd, VIDIOC_STREAMON, &type), "VIDIOC_STREAMON");
}

/* The number of the picture's frame, modulo the pattern's steps. */
static unsigned pattern_step(const uint16_t *picture, unsigned number)
{
    uint32_t n = video.width * video.height;
    uint16_t step = (uint16_t)(picture[0] - video.pattern[0]);
    unsigned n_wrong = step >= DEPTH_PATTERN_STEPS;

    for (uint32_t i = 0; i < n; i++)
        n_wrong += picture[i] != (uint16_t)(video.pattern[i] ? video.pattern[i] + step : 0);
    if (n_wrong)
        die("frame %u is no picture of the pattern: %u pixels differ from step %u", number, n_wrong,
            step);
    return step;
}

static void save(const void *picture, size_t len, const char *path)
{
    FILE *f = fopen(path, "wb");

    if (!f || fwrite(picture, 1, len, f) != len || fclose(f) != 0)
        die("%s: %s", path, strerror(errno));
}

int main(int argc, char **argv)
{
    uint32_t sequence = 0;
    unsigned n, step = 0;

    if (argc != 5 && argc != 6)
        die("usage: video_grab DEVICE FOURCC WxH N [FILE]");
    video.fd = video_open(argv[1]);
    video_set_format(video.fd, V4L2_BUF_TYPE_VIDEO_CAPTURE, argv[2], argv[3], &video.width,
                     &video.height);
    n = (unsigned)strtoul(argv[4], NULL, 10);
    video.pattern = calloc((size_t)video.width * video.height, 2);
    if (!video.pattern)
        die("out of memory");
    for (uint32_t i = 0; i < video.width * video.height; i++)
        video.pattern[i] = depth_pattern(i % video.width, i / video.width, 0);
    start();
    for (unsigned i = 0; i < n; i++) {
        struct v4l2_buffer b = {.type = V4L2_BUF_TYPE_VIDEO_CAPTURE, .memory = V4L2_MEMORY_MMAP};
        struct pollfd p = {.fd = video.fd, .events = POLLIN};
        size_t len = (size_t)video.width * video.height * 2;

        if (poll(&p, 1, WAIT_MS) != 1)
            die("frame %u does not come", i);
        check(video_ioctl(video.fd, VIDIOC_DQBUF, &b), "VIDIOC_DQBUF");
        if (i > 0)
            video.n_gaps += b.sequence - sequence - 1;
        sequence = b.sequence;
        if (b.flags & V4L2_BUF_FLAG_ERROR || b.bytesused != len) {
            video.n_errors++;
        } else if (argc == 6) {
            if (i + 1 == n)
                save(video.memory[b.index], len, argv[5]);
        } else {
            unsigned was = step;

            step = pattern_step(video.memory[b.index], i);
            if (i > 0)
                video.n_picture_gaps += (step - was - 1) % DEPTH_PATTERN_STEPS;
        }
        check(video_ioctl(video.fd, VIDIOC_QBUF, &b), "VIDIOC_QBUF");
    }
    printf("frames %u lost %u by-picture %u damaged %u\n", n, video.n_gaps, video.n_picture_gaps,
           video.n_errors);
    return 0;
}
