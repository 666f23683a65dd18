/* Testbeds for the scripted kernel: cameras are plugged in and out, scripts set, and what is left
 * behind counted. */
#ifndef V4L2_BED_H
#define V4L2_BED_H

#include "tests/unit/v4l2_kernel.h"

#include <dirent.h>

#define KERNEL_USB "/devices/pci0000:00/0000:00:14.0/usb1/1-"

/* A node of the USB device at port `port` of bus 1. */
static inline void kernel_plug(const char *name, unsigned port, const char *serial, uint32_t caps,
                               uint32_t format0, uint32_t format1)
{
    struct kernel_node *node = &kernel.nodes[kernel.n_nodes++];
    unsigned number = (unsigned)atoi(name + strlen("video"));
    char text[1200], path[64], link[64], device[16];
    int fd;

    *node = (struct kernel_node){name, serial, {format0, format1}, caps};
    snprintf(text, sizeof(text),
             "P: " KERNEL_USB "%u\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nA: idVendor=8086\n"
             "A: idProduct=0ad3\nA: serial=%s\nA: devpath=%u\nA: busnum=1\nA: devnum=%u\n\n",
             port, serial, port, 10 + port);
    if (!(kernel.ports & 1u << port))
        umockdev_testbed_add_from_string(kernel.bed, text, NULL);
    snprintf(text, sizeof(text),
             "P: " KERNEL_USB "%u/1-%u:1.0\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\n"
             "A: bInterfaceNumber=00\n\n",
             port, port);
    if (!(kernel.ports & 1u << port))
        umockdev_testbed_add_from_string(kernel.bed, text, NULL);
    kernel.ports |= 1u << port;
    snprintf(text, sizeof(text),
             "P: " KERNEL_USB "%u/1-%u:1.0/video4linux/%s\nN: %s=00\nE: SUBSYSTEM=video4linux\n"
             "S: v4l/by-path/port-%u-%s\nE: DEVNAME=/dev/%s\nE: MAJOR=81\nE: MINOR=%u\n"
             "A: name=Depth One\nA: index=0\n\n",
             port, port, name, name, port, name, name, number);
    snprintf(device, sizeof(device), "81:%u", number);
    umock_attach(kernel.bed, text, device);
    snprintf(link, sizeof(link), "v4l/by-path/port-%u-%s", port, name);
    umock_number(kernel.bed, link, device);
    snprintf(path, sizeof(path), "/dev/%s", name);
    fd = __real_open(path, O_RDWR | O_CLOEXEC);
    assert_true(fd >= 0);
    assert_int_equal(ftruncate(fd, (off_t)KERNEL_BUFFERS * KERNEL_ROOM), 0);
    if (kernel.memory)
        munmap(kernel.memory, (size_t)KERNEL_BUFFERS * KERNEL_ROOM);
    kernel.memory =
        mmap(NULL, (size_t)KERNEL_BUFFERS * KERNEL_ROOM, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    assert_true(kernel.memory != MAP_FAILED);
    close(fd);
}

static inline void kernel_unplug(const char *name, unsigned port)
{
    char path[256];

    snprintf(path, sizeof(path), "/sys" KERNEL_USB "%u/1-%u:1.0/video4linux/%s", port, port, name);
    umockdev_testbed_remove_device(kernel.bed, path);
    kernel.n_nodes = 0;
    kernel.gone = kernel.streaming = false;
}

static int kernel_set_up(void **state)
{
    (void)state;
    kernel = (struct kernel){
        .width = 16,
        .height = 6,
        .bytesperline = 32,
        .fourcc = V4L2_PIX_FMT_Z16,
        .rate = {1, 30},
        .stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE,
        .bed = umockdev_testbed_new(),
    };
    umockdev_testbed_add_from_string(
        kernel.bed, "P: /devices/pci0000:00/0000:00:14.0\nE: SUBSYSTEM=pci\n\n", NULL);
    return 0;
}

static int kernel_tear_down(void **state)
{
    (void)state;
    if (kernel.memory)
        munmap(kernel.memory, (size_t)KERNEL_BUFFERS * KERNEL_ROOM);
    g_object_unref(kernel.bed);
    return 0;
}

#define KERNEL_CAPTURE (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING)

/* A new script, from its first step on. */
#define KERNEL_SCRIPT(...)                                                                         \
    do {                                                                                           \
        const enum kernel_step steps_[] = {__VA_ARGS__, STEP_NONE};                                \
        memcpy(kernel.script, steps_, sizeof(steps_));                                             \
        kernel.at = 0;                                                                             \
    } while (0)

/* Descriptors of this process; umockdev's sockets come and go as its thread gets to them. */
static inline unsigned kernel_n_descriptors(void)
{
    DIR *dir = opendir("/proc/self/fd");
    const struct dirent *entry;
    unsigned n = 0;

    assert_non_null(dir);
    while ((entry = readdir(dir))) {
        char path[300], target[64] = "";

        snprintf(path, sizeof(path), "/proc/self/fd/%s", entry->d_name);
        n += readlink(path, target, sizeof(target) - 1) > 0 && strncmp(target, "socket:", 7) != 0;
    }
    closedir(dir);
    return n;
}

/* Mappings of nodes in this process. */
static inline unsigned kernel_n_mappings(void)
{
    FILE *maps = fopen("/proc/self/maps", "r");
    char line[512];
    unsigned n = 0;

    assert_non_null(maps);
    while (fgets(line, sizeof(line), maps))
        n += strstr(line, "/dev/") && strstr(line, "video");
    fclose(maps);
    return n;
}

#endif
