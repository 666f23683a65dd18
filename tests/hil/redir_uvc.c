/*
 * redir_uvc SOCKET ORDERS: a UVC 1.1 depth camera (Z16, 640x480, 320x240 or 160x120, 30 frames a
 * second, bulk) for QEMU's usb-redir; the guest's uvcvideo makes a /dev/video of it. Shows
 * depth_pattern(). Like a camera it leaves a frame out when nobody fetches in time.
 *
 * Orders beside plug and unplug:
 *   count        answers "sent N missed N" since it was plugged
 *   fps N        frames a second from now on
 *   memory N     frames that it keeps until they are fetched; 1 when it is plugged
 *   cut          ends the next frame in the middle
 *   bad          marks the next frame as damaged, in its header
 *   unplug-in    unplugs in the middle of the next frame
 */
#include "drivers/monotonic.h"
#include "tests/hil/redir.h"
#include "tests/hil/depth_pattern.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define WIDTH       640
#define HEIGHT      480
#define N_SIZES     3                    /* each half as wide and high as the one before */
#define FRAME_LEN   (WIDTH * HEIGHT * 2) /* of the largest */
#define PAYLOAD_LEN 16384                /* with its header; what uvcvideo fetches at once */
#define HEADER_LEN  2
#define CLOCK_HZ    48000000
#define INTERVAL    333333 /* of 100 ns */
#define SECOND_NS   1000000000ull

#define LE16(x)     (x) & 0xff, (x) >> 8 & 0xff
#define LE32(x)     LE16(x), LE16((x) >> 16)

/* the UVC specification's names, and what its bytes are */
enum {
    CLASS_VIDEO = 0x0e,
    CS_INTERFACE = 0x24,
    VC_HEADER = 1,
    VC_INPUT_TERMINAL = 2,
    VC_OUTPUT_TERMINAL = 3,
    VS_INPUT_HEADER = 1,
    VS_FORMAT_UNCOMPRESSED = 4,
    VS_FRAME_UNCOMPRESSED = 5,
    VS_PROBE_CONTROL = 1,
    VS_COMMIT_CONTROL = 2,
    SET_CUR = 0x01,
    GET_CUR = 0x81,
    GET_MIN = 0x82,
    GET_MAX = 0x83,
    GET_LEN = 0x85,
    GET_INFO = 0x86,
    GET_DEF = 0x87,
    HEADER_FRAME_ID = 0x01,
    HEADER_END_OF_FRAME = 0x02,
    HEADER_ERROR = 0x40,
    HEADER_END_OF_HEADER = 0x80,
};

static const uint8_t device[18] = {
    18, 1, LE16(0x0200), 0xef, 2, 1, 64, LE16(0x1d6b), LE16(0x0105), LE16(0x0100), 1, 2, 3, 1,
};
static const char *const strings[] = {"dexeld", "Simulated depth camera", "HIL0001", NULL};

#define VC_LEN     (13 + 18 + 9)
#define VS_LEN     (14 + 27 + N_SIZES * 30)
#define CONFIG_LEN (9 + 8 + 9 + VC_LEN + 9 + VS_LEN + 7)
/* clang-format off */
static const uint8_t config[] = {
    9, 2, LE16(CONFIG_LEN), 2, 1, 0, 0x80, 50,
    8, 11, 0, 2, CLASS_VIDEO, 3, 0, 0, /* interfaces 0 and 1 are one camera */
    9, 4, 0, 0, 0, CLASS_VIDEO, 1, 0, 0,
    13, CS_INTERFACE, VC_HEADER, LE16(0x0110), LE16(VC_LEN), LE32(CLOCK_HZ), 1, 1,
    18, CS_INTERFACE, VC_INPUT_TERMINAL, 1, LE16(0x0201), 0, 0, LE16(0), LE16(0), LE16(0), 3, 0, 0, 0,
    9, CS_INTERFACE, VC_OUTPUT_TERMINAL, 2, LE16(0x0101), 0, 1, 0,
    9, 4, 1, 0, 1, CLASS_VIDEO, 2, 0, 0,
    14, CS_INTERFACE, VS_INPUT_HEADER, 1, LE16(VS_LEN), 0x81, 0, 2, 0, 0, 0, 1, 0,
    27, CS_INTERFACE, VS_FORMAT_UNCOMPRESSED, 1, N_SIZES,
        'Z', '1', '6', ' ', 0, 0, 0x10, 0, 0x80, 0, 0, 0xaa, 0, 0x38, 0x9b, 0x71, 16, 1, 0, 0, 0, 0,
    30, CS_INTERFACE, VS_FRAME_UNCOMPRESSED, 1, 0, LE16(WIDTH), LE16(HEIGHT),
        LE32(FRAME_LEN * 8 * 30), LE32(FRAME_LEN * 8 * 30), LE32(FRAME_LEN), LE32(INTERVAL), 1, LE32(INTERVAL),
    30, CS_INTERFACE, VS_FRAME_UNCOMPRESSED, 2, 0, LE16(WIDTH / 2), LE16(HEIGHT / 2),
        LE32(FRAME_LEN * 2 * 30), LE32(FRAME_LEN * 2 * 30), LE32(FRAME_LEN / 4), LE32(INTERVAL), 1, LE32(INTERVAL),
    30, CS_INTERFACE, VS_FRAME_UNCOMPRESSED, 3, 0, LE16(WIDTH / 4), LE16(HEIGHT / 4),
        LE32(FRAME_LEN / 2 * 30), LE32(FRAME_LEN / 2 * 30), LE32(FRAME_LEN / 16), LE32(INTERVAL), 1, LE32(INTERVAL),
    7, 5, 0x81, 2, LE16(512), 0,
};
/* bmHint, bFormatIndex, bFrameIndex, dwFrameInterval, five words of compression, dwMaxVideoFrameSize,
 * dwMaxPayloadTransferSize, dwClockFrequency, bmFramingInfo, three versions */
static uint8_t stream_control[34] = {
    LE16(0), 1, 1, LE32(INTERVAL), LE16(0), LE16(0), LE16(0), LE16(0), LE16(0), LE32(FRAME_LEN),
    LE32(PAYLOAD_LEN), LE32(CLOCK_HZ), 0, 0, 0, 0,
};
/* clang-format on */
_Static_assert(sizeof(config) == CONFIG_LEN, "lengths in the descriptors");
enum { AT_FRAME_INDEX = 3, AT_MAX_FRAME = 18 }; /* in stream_control */

static struct {
    uint64_t number; /* of the frame that is sent, or the next */
    size_t at;       /* bytes of it that are sent */
    uint64_t due_ns, period_ns;
    uint64_t begun_ns; /* when the last one was begun to be sent */
    unsigned memory;   /* frames */
    unsigned long n_sent, n_missed;
    bool cut, bad, unplug; /* ordered for the next frame */
    uint8_t picture[FRAME_LEN];
} camera = {.period_ns = SECOND_NS / 30, .memory = 1};

static size_t frame_len(void)
{
    return FRAME_LEN >> 2 * (stream_control[AT_FRAME_INDEX] - 1);
}

static void choose_size(uint8_t number)
{
    stream_control[AT_FRAME_INDEX] = number;
    for (int k = 0; k < 4; k++)
        stream_control[AT_MAX_FRAME + k] = (uint8_t)(frame_len() >> 8 * k);
}

static int control(const struct redir_setup *setup, const uint8_t **bytes)
{
    static const uint8_t len[2] = {sizeof(stream_control), 0}, info[1] = {3};
    unsigned selector = setup->value >> 8;

    if ((setup->index & 0xff) != 1 ||
        (selector != VS_PROBE_CONTROL && selector != VS_COMMIT_CONTROL))
        return -1;
    switch (setup->request) {
    case SET_CUR:
        if (setup->length > AT_FRAME_INDEX && (*bytes)[AT_FRAME_INDEX] - 1u < N_SIZES)
            choose_size((*bytes)[AT_FRAME_INDEX]);
        if (selector == VS_COMMIT_CONTROL) { /* the stream begins */
            camera.at = 0;
            camera.due_ns = dx_clock_ns();
        }
        return 0;
    case GET_CUR:
    case GET_MIN:
    case GET_MAX:
    case GET_DEF:
        *bytes = stream_control;
        return sizeof(stream_control);
    case GET_LEN:
        *bytes = len;
        return sizeof(len);
    case GET_INFO:
        *bytes = info;
        return sizeof(info);
    default:
        return -1;
    }
}

static void draw(void)
{
    unsigned halved = stream_control[AT_FRAME_INDEX] - 1u;
    uint8_t *p = camera.picture;

    for (uint32_t row = 0; row < (uint32_t)HEIGHT >> halved; row++) {
        for (uint32_t col = 0; col < (uint32_t)WIDTH >> halved; col++) {
            uint16_t v = depth_pattern(col, row, camera.number);

            *p++ = (uint8_t)v;
            *p++ = (uint8_t)(v >> 8);
        }
    }
}

static void next_frame(void)
{
    camera.at = 0;
    camera.number++;
    camera.due_ns += camera.period_ns;
    camera.bad = camera.cut = false;
}

/* One payload; the last of a frame says so. */
static void send_payload(void)
{
    static uint8_t payload[PAYLOAD_LEN];
    size_t left = frame_len() - camera.at, n = PAYLOAD_LEN - HEADER_LEN;
    bool last;

    if (camera.at == 0)
        draw();
    if (n > left)
        n = left;
    last = n == left || (camera.cut && camera.at > frame_len() / 2);
    payload[0] = HEADER_LEN;
    payload[1] = (uint8_t)(HEADER_END_OF_HEADER | (camera.n_sent & HEADER_FRAME_ID) |
                           (last ? HEADER_END_OF_FRAME : 0) | (camera.bad ? HEADER_ERROR : 0));
    memcpy(payload + HEADER_LEN, camera.picture + camera.at, n);
    redir_bulk_in(payload, n + HEADER_LEN);
    camera.at += n;
    if (last) {
        camera.n_sent++;
        next_frame();
    } else if (camera.unplug && camera.at > frame_len() / 2) {
        redir_unplug();
    }
}

static int pump(void)
{
    while (redir_n_waiting()) {
        uint64_t now = dx_clock_ns();

        if (now < camera.due_ns)
            return (int)((camera.due_ns - now) / 1000000) + 1;
        /* nobody fetched while the next frames were made: it is lost */
        while (camera.at == 0 && now > camera.due_ns + camera.memory * camera.period_ns) {
            camera.n_missed++;
            next_frame();
        }
        /* what it has kept goes out at twice its rate, not all at once */
        if (camera.at == 0 && now < camera.begun_ns + camera.period_ns / 2)
            return (int)((camera.begun_ns + camera.period_ns / 2 - now) / 1000000) + 1;
        if (camera.at == 0)
            camera.begun_ns = now;
        send_payload();
    }
    return -1;
}

static void plugged(bool in)
{
    if (!in)
        return;
    camera.at = 0;
    camera.n_sent = camera.n_missed = 0;
    camera.cut = camera.bad = camera.unplug = false;
    camera.memory = 1;
    choose_size(1);
    camera.due_ns = dx_clock_ns();
}

static void order(const char *line, char *text, size_t text_len)
{
    unsigned n;

    if (strcmp(line, "count") == 0)
        snprintf(text, text_len, "sent %lu missed %lu", camera.n_sent, camera.n_missed);
    else if (sscanf(line, "fps %u", &n) == 1 && n > 0)
        camera.period_ns = SECOND_NS / n;
    else if (sscanf(line, "memory %u", &n) == 1 && n > 0)
        camera.memory = n;
    else if (strcmp(line, "cut") == 0)
        camera.cut = true;
    else if (strcmp(line, "bad") == 0)
        camera.bad = true;
    else if (strcmp(line, "unplug-in") == 0)
        camera.unplug = true;
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
        .endpoint = 0x81,
        .control = control,
        .pump = pump,
        .plugged = plugged,
        .order = order,
    };

    if (argc != 3) {
        fprintf(stderr, "usage: redir_uvc SOCKET ORDERS\n");
        return 2;
    }
    return redir_serve(&me, argv[1], argv[2]);
}
