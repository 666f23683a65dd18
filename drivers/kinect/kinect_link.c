/* Commands to a Kinect's camera and their replies. */
#include "drivers/kinect/kinect_link.h"

#include "drivers/driver.h"
#include "drivers/monotonic.h"

#include <errno.h>
#include <string.h>
#include <time.h>

#define REPLY_NS   UINT64_C(1000000000) /* for a reply to come */
#define CONTROL_MS 500
#define NEAR_MS    100 /* between the two registers */

/* Milliseconds for a transfer. */
static int control_ms(const struct dx_kinect_link *link)
{
    uint64_t now = dx_clock_ns(), left_ms;

    if (!link->due_ns)
        return CONTROL_MS;
    left_ms = link->due_ns > now ? (link->due_ns - now) / 1000000 : 0;
    return left_ms < CONTROL_MS ? (int)left_ms : CONTROL_MS;
}

static void sleep_ms(long ms)
{
    struct timespec t = {0, ms * 1000000};

    nanosleep(&t, NULL);
}

/* Asks until the reply is there: the camera says nothing, or 512 bytes of nothing, until then, and
 * first what a program before us has left unread. */
static int get_reply(struct dx_kinect_link *link, uint16_t command, const uint8_t **payload,
                     size_t *len, struct dx_err *err)
{
    const struct dx_usb_setup setup = {0xc0, 0, 0, 0};
    uint64_t until_ns = link->due_ns ? link->due_ns : dx_clock_ns() + REPLY_NS;
    struct dx_err why = {"found none"};
    size_t got;
    int r;

    do {
        r = dx_usb_control(link->usb, &setup, link->reply, sizeof(link->reply), &got,
                           control_ms(link), err);
        if (r)
            return r;
        if (got > 0 && got < sizeof(link->reply)) {
            *payload = dx_kinect_reply_get(link->reply, got, command, link->tag, len, &why);
            if (*payload)
                return 0;
        }
        sleep_ms(1);
    } while (dx_clock_ns() < until_ns);
    return dx_err_set(err, -EPROTO, "Kinect at port %s: no reply to command 0x%02x in time: %s",
                      dx_usb_tell(link->usb)->port, command, why.text);
}

static int command(struct dx_kinect_link *link, uint16_t command_id, const uint16_t *words,
                   unsigned n_words, const uint8_t **payload, size_t *len, struct dx_err *err)
{
    const struct dx_usb_setup setup = {0x40, 0, 0, 0};
    uint8_t bytes[DX_KINECT_MESSAGE_LEN + 2 * DX_KINECT_MAX_WORDS];
    size_t n = dx_kinect_request_put(bytes, command_id, link->tag, words, n_words);
    int r = dx_usb_control(link->usb, &setup, bytes, n, NULL, control_ms(link), err);

    if (r == 0)
        r = get_reply(link, command_id, payload, len, err);
    link->tag++;
    return r;
}

static int write_register(struct dx_kinect_link *link, struct dx_kinect_write w, struct dx_err *err)
{
    const uint16_t words[] = {w.reg, w.value};
    const uint8_t *payload;
    size_t len;
    int r = command(link, DX_KINECT_WRITE, words, 2, &payload, &len, err);

    if (r)
        return r;
    if (len < 2 || payload[0] || payload[1])
        return dx_err_set(err, -EPROTO, "Kinect at port %s: register 0x%02x does not take %u",
                          dx_usb_tell(link->usb)->port, w.reg, w.value);
    return 0;
}

int dx_kinect_link_constants(struct dx_kinect_link *link, struct dx_kinect_constants *c,
                             struct dx_err *err)
{
    const uint16_t none[5] = {0}, shift[5] = {0, 0, 1, 30, 0}; /* of 640 x 480 at 30 a second */
    const char *wrong = NULL;
    const uint8_t *payload;
    size_t len;
    int r = command(link, DX_KINECT_FIXED, none, 5, &payload, &len, err);

    if (r)
        return r;
    if (!dx_kinect_fixed_get(c, payload, len))
        wrong = "too few of them";
    r = wrong ? 0 : command(link, DX_KINECT_ALGORITHM, shift, 5, &payload, &len, err);
    if (r)
        return r;
    if (!wrong && !dx_kinect_shift_get(c, payload, len))
        wrong = "no shift";
    if (!wrong)
        wrong = dx_kinect_constants_wrong(c);
    if (wrong)
        return dx_err_set(err, -EPROTO, "Kinect at port %s: its constants are of no camera: %s",
                          dx_usb_tell(link->usb)->port, wrong);
    return 0;
}

int dx_kinect_link_start(struct dx_kinect_link *link, int bits, struct dx_err *err)
{
    struct dx_kinect_write writes[DX_KINECT_N_START];
    int r = 0;

    dx_kinect_start_writes(writes, bits);
    for (unsigned k = 0; k < DX_KINECT_N_START && r == 0; k++)
        r = write_register(link, writes[k], err);
    return r;
}

int dx_kinect_link_stop(struct dx_kinect_link *link, struct dx_err *err)
{
    return write_register(link, (struct dx_kinect_write){DX_KINECT_DEPTH_STREAM, 0}, err);
}

int dx_kinect_link_near(struct dx_kinect_link *link, bool near, struct dx_err *err)
{
    struct dx_kinect_write writes[2];
    int r;

    dx_kinect_near_writes(writes, near);
    r = write_register(link, writes[0], err);
    if (r)
        return r;
    sleep_ms(NEAR_MS);
    return write_register(link, writes[1], err);
}
