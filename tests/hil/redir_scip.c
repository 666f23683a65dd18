/*
 * redir_scip SOCKET ORDERS: the simulated SCIP scanner (scip_device.h), a URG-04LX, for QEMU's
 * usb-redir: CDC-ACM at full speed, as the scanner has it, so the guest's cdc-acm makes a tty of it
 * and libusb finds its bulk endpoints. Its stage stands still: the guest has a clock of its own,
 * and who takes the stage for turning sees the body of revolution of one scan.
 *
 * Orders beside plug and unplug:
 *   count        answers "sent N", scans since it was plugged
 *   bad-sum N    every Nth scan has a wrong check character; 0: none
 *   mute N       1: answers nothing any more; 0: does again
 */
#include "drivers/monotonic.h"
#include "tests/hil/redir.h"
#include "tests/hil/scip_device.h"

#include <stdio.h>
#include <string.h>

#define PACKET_LEN 64
#define LE16(x)    (x) & 0xff, (x) >> 8 & 0xff

/* the specification's names (CDC 1.1), and what its bytes are */
enum {
    CLASS_COMM = 2,
    CLASS_DATA = 10,
    CS_INTERFACE = 0x24,
    SUBCLASS_ACM = 2,
    PROTOCOL_AT = 1,
    HEADER = 0,
    CALL_MANAGEMENT = 1,
    ACM = 2,
    UNION = 6,
    SET_LINE_CODING = 0x20,
    GET_LINE_CODING = 0x21,
    SET_CONTROL_LINE_STATE = 0x22,
    NOTIFY_IN = 0x83,
    DATA_IN = 0x81,
    DATA_OUT = 0x02,
};

static const uint8_t device[18] = {
    18,
    1,
    LE16(0x0200),
    CLASS_COMM,
    0,
    0,
    PACKET_LEN,
    LE16(0x15d1),
    LE16(0x0000),
    LE16(0x0100),
    1,
    2,
    0,
    1,
};
static const char *const strings[] = {"Hokuyo Data Flex for USB", "URG-Series USB Driver", NULL};

#define CONFIG_LEN (9 + 9 + 5 + 5 + 4 + 5 + 7 + 9 + 7 + 7)
/* clang-format off */
static const uint8_t config[] = {
    9, 2, LE16(CONFIG_LEN), 2, 1, 0, 0xc0, 50,
    9, 4, 0, 0, 1, CLASS_COMM, SUBCLASS_ACM, PROTOCOL_AT, 0,
    5, CS_INTERFACE, HEADER, LE16(0x0110),
    5, CS_INTERFACE, CALL_MANAGEMENT, 0, 1,
    4, CS_INTERFACE, ACM, 2, /* line coding and state */
    5, CS_INTERFACE, UNION, 0, 1,
    7, 5, NOTIFY_IN, 3, LE16(8), 10,
    9, 4, 1, 0, 2, CLASS_DATA, 0, 0, 0,
    7, 5, DATA_IN, 2, LE16(PACKET_LEN), 0,
    7, 5, DATA_OUT, 2, LE16(PACKET_LEN), 0,
};
/* clang-format on */
_Static_assert(sizeof(config) == CONFIG_LEN, "lengths in the descriptors");

static struct scip_sim sim;

static int control(const struct redir_setup *setup, const uint8_t **bytes)
{
    static const uint8_t coding[7] = {0x00, 0xc2, 0x01, 0x00, 0, 0, 8}; /* 115200 8N1 */

    switch (setup->request) {
    case SET_LINE_CODING: /* a scanner on USB has no line */
    case SET_CONTROL_LINE_STATE:
        return 0;
    case GET_LINE_CODING:
        *bytes = coding;
        return sizeof(coding);
    default:
        return -1;
    }
}

static void came(const uint8_t *bytes, size_t len)
{
    scip_sim_feed(&sim, bytes, len, dx_clock_ns());
}

/* One answer. That it is the last before the device is unplugged shows only when it has gone out.
 */
static void answer(void)
{
    static uint8_t bytes[SCIP_SIM_OUT];
    size_t room = redir_bulk_room(), n = sim.out_len < room ? sim.out_len : room;

    memcpy(bytes, sim.out, n);
    scip_sim_sent(&sim, n);
    redir_bulk_in(bytes, n);
}

/* A reboot does not take it off the bus. */
static int pump(void)
{
    uint64_t now = dx_clock_ns(), next;

    scip_sim_tick(&sim, now);
    while (redir_n_waiting() && sim.out_len)
        answer();
    next = scip_sim_next_ns(&sim);
    if (next == UINT64_MAX)
        return -1;
    return next > now ? (int)((next - now) / 1000000) + 1 : 0;
}

static void plugged(bool in)
{
    scip_sim_init(&sim, &scip_models[0], dx_clock_ns());
    memcpy(sim.room, (const double[6]){-2, -1.5, -0.8, 3, 2.5, 1.7}, sizeof(sim.room));
    if (in)
        scip_sim_open(&sim, dx_clock_ns());
}

static void order(const char *line, char *text, size_t text_len)
{
    unsigned n;

    if (strcmp(line, "count") == 0)
        snprintf(text, text_len, "sent %llu", (unsigned long long)sim.n_scans);
    else if (sscanf(line, "bad-sum %u", &n) == 1)
        sim.faults.bad_sum_every = n;
    else if (sscanf(line, "mute %u", &n) == 1)
        sim.faults.mute = n != 0;
    else
        snprintf(text, text_len, "unknown order");
}

int main(int argc, char **argv)
{
    static const struct redir_device me = {
        .device = device,
        .config = config,
        .config_len = sizeof(config),
        .strings = strings,
        .full_speed = true,
        .endpoint = DATA_IN,
        .out = DATA_OUT,
        .control = control,
        .pump = pump,
        .came = came,
        .plugged = plugged,
        .order = order,
    };

    if (argc != 3) {
        fprintf(stderr, "usage: redir_scip SOCKET ORDERS\n");
        return 2;
    }
    return redir_serve(&me, argv[1], argv[2]);
}
