/* A fake of libusb; fake_libusb.h says what it is good for. */
#include "tests/unit/fake_libusb.h"

#include "drivers/kinect/kinect_protocol.h"
#include "drivers/monotonic.h"

#include <libusb-1.0/libusb.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

#define MAX_FLYING 64

struct libusb_context {
    int fd;    /* readable while something can come back */
    int timer; /* readable when the next isochronous transfer is due */
    struct libusb_pollfd pollfds[2];
};
struct libusb_device {
    int refs;
};
struct libusb_device_handle {
    struct libusb_context *context;
};

struct fake_libusb fake_libusb;
static struct libusb_device device;
static struct libusb_context *newest; /* of the one device that is open */
static struct flight {
    struct libusb_transfer *transfer;
    bool cancelled;
} flights[MAX_FLYING];
/* What never came back, as the kernel would hold it: no leak to those who look for one. */
static struct libusb_transfer *kept[MAX_FLYING];

void fake_libusb_reset(void)
{
    for (unsigned k = 0; k < MAX_FLYING; k++)
        if (flights[k].transfer)
            kept[k] = flights[k].transfer;
    memset(&fake_libusb, 0, sizeof(fake_libusb));
    memset(flights, 0, sizeof(flights));
    kinect_sim_init(&fake_libusb.sim);
    fake_libusb.plugged = true;
    fake_libusb.burst = 1;
}

/* ---- contexts and devices
 * ------------------------------------------------------------------------ */

int libusb_init(libusb_context **context)
{
    *context = calloc(1, sizeof(**context));
    (*context)->fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    (*context)->timer = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    (*context)->pollfds[0] = (struct libusb_pollfd){(*context)->fd, 1 /* POLLIN */};
    (*context)->pollfds[1] = (struct libusb_pollfd){(*context)->timer, 1};
    newest = *context;
    fake_libusb.n_contexts++;
    return 0;
}

void libusb_exit(libusb_context *context)
{
    close(context->fd);
    close(context->timer);
    free(context);
    fake_libusb.n_contexts--;
}

const char *libusb_strerror(int code)
{
    return code == LIBUSB_ERROR_BUSY ? "Resource busy" : "Fake error";
}

ssize_t libusb_get_device_list(libusb_context *context, libusb_device ***list)
{
    (void)context;
    *list = calloc(2, sizeof(libusb_device *));
    **list = fake_libusb.plugged ? &device : NULL;
    fake_libusb.n_lists++;
    return fake_libusb.plugged;
}

void libusb_free_device_list(libusb_device **list, int unref)
{
    (void)unref;
    free(list);
    fake_libusb.n_lists--;
}

uint8_t libusb_get_bus_number(libusb_device *d)
{
    (void)d;
    return 3;
}

uint8_t libusb_get_device_address(libusb_device *d)
{
    (void)d;
    return 7;
}

int libusb_get_port_numbers(libusb_device *d, uint8_t *ports, int len)
{
    (void)d;
    (void)len;
    ports[0] = 1;
    ports[1] = 4;
    return 2;
}

int libusb_get_device_descriptor(libusb_device *d, struct libusb_device_descriptor *out)
{
    (void)d;
    *out = (struct libusb_device_descriptor){
        .idVendor = 0x045e,
        .idProduct = fake_libusb.sim.windows ? 0x02bf : 0x02ae,
        .bcdDevice = 0x010b,
        .iProduct = 2,
        .iSerialNumber = 3,
    };
    return 0;
}

int libusb_open(libusb_device *d, libusb_device_handle **handle)
{
    (void)d;
    if (fake_libusb.open_error)
        return fake_libusb.open_error;
    *handle = calloc(1, sizeof(**handle));
    (*handle)->context = newest;
    fake_libusb.n_handles++;
    return 0;
}

void libusb_close(libusb_device_handle *handle)
{
    free(handle);
    fake_libusb.n_handles--;
}

libusb_device *libusb_get_device(libusb_device_handle *handle)
{
    (void)handle;
    return &device;
}

int libusb_get_string_descriptor_ascii(libusb_device_handle *handle, uint8_t index,
                                       unsigned char *text, int len)
{
    const char *serial = fake_libusb.serial ? fake_libusb.serial : "A00366902968103A";

    (void)handle;
    return snprintf((char *)text, (size_t)len, "%s", index == 3 ? serial : "Xbox NUI Camera");
}

int libusb_set_auto_detach_kernel_driver(libusb_device_handle *handle, int enable)
{
    (void)handle;
    return enable ? 0 : LIBUSB_ERROR_OTHER;
}

int libusb_claim_interface(libusb_device_handle *handle, int interface)
{
    (void)handle;
    if (fake_libusb.claim_error || interface != 0)
        return fake_libusb.claim_error ? fake_libusb.claim_error : LIBUSB_ERROR_NOT_FOUND;
    fake_libusb.n_claimed++;
    return 0;
}

int libusb_release_interface(libusb_device_handle *handle, int interface)
{
    (void)handle;
    (void)interface;
    fake_libusb.n_claimed--;
    return 0;
}

int libusb_set_interface_alt_setting(libusb_device_handle *handle, int interface, int alt)
{
    (void)handle;
    (void)interface;
    fake_libusb.alt = alt;
    return 0;
}

int libusb_get_active_config_descriptor(libusb_device *d, struct libusb_config_descriptor **out)
{
    (void)d;
    *out = calloc(1, sizeof(**out));
    fake_libusb.n_configs++;
    return 0;
}

void libusb_free_config_descriptor(struct libusb_config_descriptor *config)
{
    free(config);
    fake_libusb.n_configs--;
}

int libusb_get_max_iso_packet_size(libusb_device *d, unsigned char endpoint)
{
    (void)d;
    return endpoint == 0x82 ? 1920 : LIBUSB_ERROR_NOT_FOUND;
}

/* ---- transfers
 * ------------------------------------------------------------------------------------ */

struct libusb_transfer *libusb_alloc_transfer(int n_packets)
{
    struct libusb_transfer *t =
        calloc(1, sizeof(*t) + (size_t)n_packets * sizeof(struct libusb_iso_packet_descriptor));

    fake_libusb.n_transfers++;
    return t;
}

void libusb_free_transfer(struct libusb_transfer *t)
{
    fake_libusb.n_transfers -= t != NULL;
    free(t);
}

static bool is_due(void)
{
    return !fake_libusb.transfer_ns || dx_clock_ns() >= fake_libusb.due_ns;
}

static bool can_come_back(const struct flight *f)
{
    if (!f->transfer || (f->cancelled && fake_libusb.never_return))
        return false;
    return f->cancelled || !fake_libusb.plugged || fake_libusb.transfer_status ||
           f->transfer->type == LIBUSB_TRANSFER_TYPE_CONTROL ||
           (kinect_sim_streams(&fake_libusb.sim) && is_due());
}

static void set_timer(struct libusb_context *context)
{
    struct itimerspec t = {.it_value = {(time_t)(fake_libusb.due_ns / 1000000000u),
                                        (long)(fake_libusb.due_ns % 1000000000u)}};

    if (fake_libusb.transfer_ns && fake_libusb.due_ns)
        timerfd_settime(context->timer, TFD_TIMER_ABSTIME, &t, NULL);
}

/* The descriptor is readable when, and only when, there is something to do. */
static void set_ready(struct libusb_context *context)
{
    uint64_t n = 0;

    set_timer(context);
    for (unsigned k = 0; k < MAX_FLYING; k++)
        n += can_come_back(&flights[k]);
    if (n && write(context->fd, &n, sizeof(n)) < 0)
        abort();
    if (!n && read(context->fd, &n, sizeof(n)) < 0)
        return; /* was not readable */
}

int libusb_submit_transfer(struct libusb_transfer *t)
{
    unsigned k = 0;

    if (!fake_libusb.plugged)
        return LIBUSB_ERROR_NO_DEVICE;
    while (k < MAX_FLYING && flights[k].transfer)
        k++;
    if (k == MAX_FLYING)
        return LIBUSB_ERROR_NO_MEM;
    flights[k] = (struct flight){.transfer = t};
    fake_libusb.n_flying++;
    set_ready(t->dev_handle->context);
    return 0;
}

int libusb_cancel_transfer(struct libusb_transfer *t)
{
    for (unsigned k = 0; k < MAX_FLYING; k++)
        if (flights[k].transfer == t) {
            flights[k].cancelled = true;
            set_ready(t->dev_handle->context);
            return 0;
        }
    return LIBUSB_ERROR_NOT_FOUND;
}

static void do_control(struct libusb_transfer *t)
{
    struct kinect_sim *sim = &fake_libusb.sim;
    const uint8_t *setup = t->buffer;
    int len = t->length - (int)LIBUSB_CONTROL_SETUP_SIZE, n;
    bool before = kinect_sim_streams(sim);

    n = setup[0] & 0x80 ? kinect_sim_in(sim, t->buffer + LIBUSB_CONTROL_SETUP_SIZE, (size_t)len)
                        : kinect_sim_out(sim, setup + LIBUSB_CONTROL_SETUP_SIZE, (size_t)len);
    t->status = n < 0 ? LIBUSB_TRANSFER_STALL : LIBUSB_TRANSFER_COMPLETED;
    t->actual_length = n < 0 ? 0 : n;
    if (!before && kinect_sim_streams(sim))
        fake_libusb.flying_at_start = fake_libusb.n_flying;
}

static void do_isochronous(struct libusb_transfer *t)
{
    uint64_t n_frames = fake_libusb.sim.n_frames;
    uint8_t *at = t->buffer;

    t->status = (enum libusb_transfer_status)fake_libusb.transfer_status;
    fake_libusb.n_isochronous++;
    for (int k = 0; k < t->num_iso_packets && t->status == 0; k++) {
        struct libusb_iso_packet_descriptor *p = &t->iso_packet_desc[k];

        p->actual_length = (unsigned)kinect_sim_packet(&fake_libusb.sim, at);
        p->status = k % 10 == 9 ? (enum libusb_transfer_status)fake_libusb.packet_status : 0;
        at += p->length;
    }
    if (fake_libusb.n_isochronous == fake_libusb.unplug_after)
        fake_libusb.plugged = false;
    if (fake_libusb.sim.n_frames != n_frames)
        fake_libusb.frame_ns = fake_libusb.due_ns;
    fake_libusb.due_ns += fake_libusb.transfer_ns;
}

static void come_back(struct flight *f)
{
    struct libusb_transfer *t = f->transfer;

    t->status = f->cancelled           ? LIBUSB_TRANSFER_CANCELLED
                : !fake_libusb.plugged ? LIBUSB_TRANSFER_NO_DEVICE
                                       : LIBUSB_TRANSFER_COMPLETED;
    if (t->status == LIBUSB_TRANSFER_COMPLETED && t->type == LIBUSB_TRANSFER_TYPE_CONTROL)
        do_control(t);
    else if (t->status == LIBUSB_TRANSFER_COMPLETED)
        do_isochronous(t);
    f->transfer = NULL;
    fake_libusb.n_flying--;
    t->callback(t);
}

int libusb_handle_events_timeout_completed(libusb_context *context, struct timeval *tv,
                                           int *completed)
{
    static unsigned next; /* in the order of queueing, about */
    unsigned burst = 0;

    (void)tv;
    (void)completed;
    for (unsigned k = 0; k < MAX_FLYING; k++) /* the bus is not that slow */
        if (can_come_back(&flights[k]) && flights[k].transfer->type == LIBUSB_TRANSFER_TYPE_CONTROL)
            come_back(&flights[k]);
    for (unsigned k = 0; k < MAX_FLYING * fake_libusb.burst; k++) {
        struct flight *f = &flights[next++ % MAX_FLYING];

        if (!can_come_back(f))
            continue;
        if (f->transfer->type == LIBUSB_TRANSFER_TYPE_ISOCHRONOUS && !f->cancelled &&
            fake_libusb.plugged && ++burst > fake_libusb.burst) {
            next--;
            break;
        }
        come_back(f);
    }
    set_ready(context);
    return 0;
}

const struct libusb_pollfd **libusb_get_pollfds(libusb_context *context)
{
    const struct libusb_pollfd **fds = calloc(3, sizeof(struct libusb_pollfd *));

    fds[0] = &context->pollfds[0];
    fds[1] = &context->pollfds[1];
    return fds;
}

void libusb_free_pollfds(const struct libusb_pollfd **fds)
{
    free(fds);
}

void libusb_set_pollfd_notifiers(libusb_context *context, libusb_pollfd_added_cb added,
                                 libusb_pollfd_removed_cb removed, void *ctx)
{
    (void)context;
    (void)added;
    (void)removed;
    (void)ctx;
}
