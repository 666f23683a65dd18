/*
 * bench_v4l2 [SECONDS]: the V4L2 driver with Z16 frames of 848x480, 90 a second, on the scripted
 * kernel of the unit tests: nodes of umockdev, ioctl() and poll() answered in the process, so no
 * system call of the kernel's V4L2 is in it.
 */
#define KERNEL_ROOM (1u << 20) /* a frame's */

#include "tests/bench/driver_bench.h"
#include "tests/unit/v4l2_bed.h"
#include "tests/unit/v4l2_fixture.h"

static uint64_t last_byte_ns(void)
{
    return kernel.told_ns;
}

int main(int argc, char **argv)
{
    static struct driver_bench b = {.name = "V4L2 Z16, 848x480",
                                    .driver = &dx_v4l2_driver,
                                    .hz = 90,
                                    .last_byte_ns = last_byte_ns};
    struct dx_v4l2_config c = v4l2_config();
    int r;

    kernel_set_up(NULL);
    kernel.width = 848;
    kernel.height = 480;
    kernel.bytesperline = 2 * 848;
    kernel_plug("video0", 2, "1", KERNEL_CAPTURE, V4L2_PIX_FMT_Z16, 0);
    for (unsigned k = 0; k < KERNEL_BUFFERS; k++)
        kernel_draw(kernel.memory + (size_t)k * KERNEL_ROOM, k);
    kernel.frame_ns = (uint64_t)(1e9 / b.hz);
    kernel.due_ns = dx_now_ns() + 1000000000u;
    c.lens.fx = 425;
    b.config = &c;
    r = driver_bench_run(&b, driver_bench_seconds(argc, argv));
    kernel_tear_down(NULL);
    return r;
}
