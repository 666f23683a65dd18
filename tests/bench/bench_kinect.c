/*
 * bench_kinect [SECONDS]: the Kinect driver at 30 frames a second, over the fake of libusb, whose
 * transfers come back by the clock. No usbfs is in it; that the fake fills the transfers is, as
 * the kernel copies them.
 */
#include "tests/bench/driver_bench.h"
#include "tests/unit/fake_libusb.h"

#include "drivers/kinect/kinect.h"

#define N_PACKETS 16 /* of a transfer */

static uint64_t last_byte_ns(void)
{
    return fake_libusb.frame_ns;
}

int main(int argc, char **argv)
{
    static char none[] = "";
    static const struct dx_kinect_config config = {
        .serial = none, .port = none, .bits = 11, .max_m = 10, .cx = -1, .cy = -1};
    static struct driver_bench b = {.name = "Kinect, 640x480",
                                    .driver = &dx_kinect_driver,
                                    .config = &config,
                                    .hz = 30,
                                    .last_byte_ns = last_byte_ns};
    static uint16_t codes[DX_KINECT_PIXELS];

    fake_libusb_reset();
    for (uint32_t k = 0; k < DX_KINECT_PIXELS; k++)
        codes[k] = (uint16_t)(k % 11 ? 500 + k % 480 : 2047);
    kinect_sim_codes(&fake_libusb.sim, codes);
    fake_libusb.transfer_ns = (uint64_t)(1e9 / b.hz / 242 * N_PACKETS);
    fake_libusb.due_ns = dx_now_ns() + 1000000000u;
    return driver_bench_run(&b, driver_bench_seconds(argc, argv));
}
