/*
 * redir_kinect SOCKET ORDERS: the camera of a Kinect for Xbox 360 (kinect_sim.c) for QEMU's
 * usb-redir: depths on an isochronous endpoint. Shows depth_pattern(), nearer, as the camera's
 * codes can tell it, always the same picture, ten times a second.
 * redir_kinect --pixels FILE writes that picture: 16-bit millimetres as the codes mean them.
 *
 * Orders beside plug and unplug:
 *   count        answers "sent N", frames since it was plugged
 *   fps N        frames a second from now on
 *   lose N       loses N of a million packets from now on
 *   unplug-in    unplugs in the middle of the next frame
 */
#include "drivers/monotonic.h"
#include "tests/hil/depth_pattern.h"
#include "tests/hil/kinect_sim.h"
#include "tests/hil/redir.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH     640
#define NEARER_MM 700
#define SECOND_NS 1000000000ull
#define LE16(x)   (x) & 0xff, (x) >> 8 & 0xff

static const uint8_t device[18] = {
    18, 1, LE16(0x0200), 0, 0, 0, 64, LE16(0x045e), LE16(0x02ae), LE16(0x010b), 1, 2, 3, 1,
};
static const char *const strings[] = {"Microsoft", "Xbox NUI Camera", "A00HIL0000000001", NULL};
/* Isochronous endpoints of video and depth: two transactions of 960 bytes each microframe. */
static const uint8_t config[] = {
    9,    2,    LE16(32), 1, 1,
    0,    0xc0, 8, /* one interface */
    9,    4,    0,        0, 2,
    0xff, 0,    0,        0, /* vendor's class */
    7,    5,    0x81,     1, LE16(1 << 11 | 960),
    1, /* video: never sent */
    7,    5,    0x82,     1, LE16(1 << 11 | 960),
    1, /* depth */
};

static struct kinect_sim sim;
static struct {
    uint64_t due_ns, period_ns;
    bool unplug;
} camera = {.period_ns = SECOND_NS / 10};

static void draw(void)
{
    static uint16_t mm[DX_KINECT_PIXELS];

    for (uint32_t i = 0; i < DX_KINECT_PIXELS; i++) {
        uint16_t depth = depth_pattern(i % WIDTH, i / WIDTH, 0);

        mm[i] = depth ? (uint16_t)(depth - NEARER_MM) : 0;
    }
    kinect_sim_depths(&sim, mm);
}

static int control(const struct redir_setup *setup, const uint8_t **bytes)
{
    static uint8_t reply[512];
    int n;

    if ((setup->type & 0x60) != 0x40)
        return -1;
    if (!(setup->type & 0x80))
        return kinect_sim_out(&sim, *bytes, setup->length) < 0 ? -1 : 0;
    n = kinect_sim_in(&sim, reply, setup->length < sizeof(reply) ? setup->length : sizeof(reply));
    *bytes = reply;
    return n;
}

/* A frame at a time: QEMU keeps the packets until the guest fetches them. */
static int pump(void)
{
    uint64_t now = dx_clock_ns(), frame = sim.n_frames;
    unsigned half = 0;

    if (!redir_iso_runs() || !kinect_sim_streams(&sim))
        return -1;
    if (now < camera.due_ns)
        return (int)((camera.due_ns - now) / 1000000) + 1;
    camera.due_ns += camera.period_ns;
    if (camera.due_ns < now)
        camera.due_ns = now;
    while (sim.n_frames == frame) {
        uint8_t packet[DX_KINECT_PACKET_LEN];
        size_t len = kinect_sim_packet(&sim, packet);

        redir_iso_in(packet, len);
        if (camera.unplug && ++half > 100) {
            redir_unplug();
            return -1;
        }
    }
    return 0;
}

static void plugged(bool in)
{
    kinect_sim_init(&sim);
    draw();
    camera.unplug = false;
    if (in)
        camera.due_ns = dx_clock_ns();
}

static void order(const char *line, char *text, size_t text_len)
{
    unsigned n;

    if (strcmp(line, "count") == 0)
        snprintf(text, text_len, "sent %llu", (unsigned long long)sim.n_frames);
    else if (sscanf(line, "fps %u", &n) == 1 && n > 0)
        camera.period_ns = SECOND_NS / n;
    else if (sscanf(line, "lose %u", &n) == 1)
        sim.faults.lose_ppm = n;
    else if (strcmp(line, "unplug-in") == 0)
        camera.unplug = true;
    else
        snprintf(text, text_len, "unknown order");
}

static int write_pixels(const char *path)
{
    static uint16_t lut[DX_KINECT_N_CODES], mm[DX_KINECT_PIXELS];
    FILE *f = fopen(path, "wb");

    plugged(false);
    dx_kinect_lut_fill(lut, &sim.constants, kinect_sim_bits(&sim), 10000);
    dx_kinect_unpack(mm, sim.packed, DX_KINECT_PIXELS, kinect_sim_bits(&sim), lut);
    if (!f || fwrite(mm, sizeof(mm), 1, f) != 1 || fclose(f) != 0) {
        perror(path);
        return 1;
    }
    return 0;
}

int main(int argc, char **argv)
{
    static const struct redir_device me = {
        .device = device,
        .config = config,
        .config_len = sizeof(config),
        .strings = strings,
        .endpoint = 0x82,
        .control = control,
        .pump = pump,
        .plugged = plugged,
        .order = order,
    };

    if (argc == 3 && strcmp(argv[1], "--pixels") == 0)
        return write_pixels(argv[2]);
    if (argc != 3) {
        fprintf(stderr, "usage: redir_kinect SOCKET ORDERS | --pixels FILE\n");
        return 2;
    }
    return redir_serve(&me, argv[1], argv[2]);
}
