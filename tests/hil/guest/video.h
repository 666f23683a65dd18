/*
 * What the small V4L2 programs of the guest share: saying why not, sizes and formats from words.
 */
#ifndef HIL_VIDEO_H
#define HIL_VIDEO_H

#include <errno.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

__attribute__((format(printf, 1, 2), noreturn)) static inline void die(const char *fmt, ...)
{
    va_list ap;

    va_start(ap, fmt);
    vfprintf(stderr, fmt, ap);
    va_end(ap);
    fputc('\n', stderr);
    exit(1);
}

static inline int video_open(const char *path)
{
    int fd = open(path, O_RDWR | O_CLOEXEC);

    if (fd < 0)
        die("%s: %s", path, strerror(errno));
    return fd;
}

static inline int video_ioctl(int fd, unsigned long request, void *arg)
{
    int r;

    do
        r = ioctl(fd, request, arg);
    while (r < 0 && errno == EINTR);
    return r < 0 ? -errno : 0;
}

/* Sets a format of 16-bit pixels without padding: `fourcc` of up to four letters, "640x480". */
static inline void video_set_format(int fd, uint32_t type, const char *fourcc, const char *size,
                                    uint32_t *width, uint32_t *height)
{
    struct v4l2_format f = {.type = type};
    char letters[5] = "    ";
    int r;

    memcpy(letters, fourcc, strnlen(fourcc, 4));
    if (sscanf(size, "%ux%u", width, height) != 2)
        die("a size was expected, not '%s'", size);
    f.fmt.pix.width = *width;
    f.fmt.pix.height = *height;
    f.fmt.pix.pixelformat = v4l2_fourcc(letters[0], letters[1], letters[2], letters[3]);
    f.fmt.pix.field = V4L2_FIELD_NONE;
    f.fmt.pix.bytesperline = *width * 2;
    f.fmt.pix.sizeimage = *width * *height * 2;
    r = video_ioctl(fd, VIDIOC_S_FMT, &f);
    if (r < 0)
        die("VIDIOC_S_FMT %s %s: %s", fourcc, size, strerror(-r));
    if (f.fmt.pix.width != *width || f.fmt.pix.height != *height ||
        f.fmt.pix.bytesperline != *width * 2 || memcmp(&f.fmt.pix.pixelformat, letters, 4) != 0)
        die("the device makes it %.4s %ux%u of %u bytes a line",
            (const char *)&f.fmt.pix.pixelformat, f.fmt.pix.width, f.fmt.pix.height,
            f.fmt.pix.bytesperline);
}

#endif
