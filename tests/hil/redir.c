/*
 * The usbredir side of a simulated USB device (redir.h): the protocol's "usb-host", spoken by
 * libusbredirparser over a connected socket.
 */
#include "tests/hil/redir_priv.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#include <usbredirparser.h>

#define MAX_WAITING 64
/* usbredir numbers endpoints 0-15 OUT, 16-31 IN */
#define SLOT(address) (((address)&0x0f) | ((address)&0x80) >> 3)

/* A port of the guest's controller; of each call of the library, `priv`. */
struct port {
    struct usbredirparser *parser;
    int fd;
    bool greeted;
};

struct request { /* of bulk IN */
    uint64_t id;
    size_t len;
};

static struct {
    const struct redir_device *device;
    struct port ports[REDIR_N_PORTS];
    struct port *in, *last;              /* where the device is plugged, or NULL; and was before */
    uint64_t left;                       /* bytes until it is unplugged; UINT64_MAX: never */
    struct request waiting[MAX_WAITING]; /* the oldest first */
    unsigned n_waiting;
    bool iso_runs;
} bus = {.last = bus.ports, .left = UINT64_MAX};

/* ---- what the library asks for ------------------------------------------------------------ */

static void on_log(void *priv, int level, const char *text)
{
    (void)priv;
    if (level <= usbredirparser_warning)
        fprintf(stderr, "redir: %s\n", text);
}

static int on_read(void *priv, uint8_t *data, int count)
{
    const struct port *port = priv;
    ssize_t n = read(port->fd, data, (size_t)count);

    if (n < 0)
        return errno == EAGAIN ? 0 : -1;
    return n == 0 ? -1 : (int)n;
}

static int on_write(void *priv, uint8_t *data, int count)
{
    const struct port *port = priv;
    ssize_t n = write(port->fd, data, (size_t)count);

    if (n < 0)
        return errno == EAGAIN ? 0 : -1;
    return (int)n;
}

static void on_hello(void *priv, struct usb_redir_hello_header *hello)
{
    struct port *port = priv;

    fprintf(stderr, "redir: peer %.64s\n", hello->version);
    port->greeted = true;
}

static void on_nothing(void *priv)
{
    (void)priv;
}

/* ---- the device's own facts ----------------------------------------------------------------- */

static uint16_t u16_at(const uint8_t *p)
{
    return (uint16_t)(p[0] | p[1] << 8);
}

/* Interfaces and endpoints, read from the configuration's descriptors. */
static void send_facts(const struct redir_device *d)
{
    struct usb_redir_interface_info_header interfaces = {0};
    struct usb_redir_ep_info_header endpoints;
    uint8_t number = 0;

    memset(&endpoints, 0, sizeof(endpoints));
    memset(endpoints.type, usb_redir_type_invalid, sizeof(endpoints.type));
    endpoints.type[SLOT(0x00)] = endpoints.type[SLOT(0x80)] = usb_redir_type_control;
    endpoints.max_packet_size[SLOT(0x00)] = endpoints.max_packet_size[SLOT(0x80)] = d->device[7];
    for (size_t at = 0; at + 7 <= d->config_len; at += d->config[at]) {
        const uint8_t *p = d->config + at;
        uint32_t n = interfaces.interface_count;

        if (p[1] == TYPE_INTERFACE && p[3] == 0) {
            number = p[2];
            interfaces.interface[n] = number;
            interfaces.interface_class[n] = p[5];
            interfaces.interface_subclass[n] = p[6];
            interfaces.interface_protocol[n] = p[7];
            interfaces.interface_count = n + 1;
        } else if (p[1] == TYPE_ENDPOINT) {
            endpoints.type[SLOT(p[2])] = p[3] & 3;
            endpoints.interval[SLOT(p[2])] = p[6];
            endpoints.interface[SLOT(p[2])] = number;
            endpoints.max_packet_size[SLOT(p[2])] = u16_at(p + 4);
        }
    }
    usbredirparser_send_interface_info(bus.in->parser, &interfaces);
    usbredirparser_send_ep_info(bus.in->parser, &endpoints);
}

void redir_plug(bool elsewhere)
{
    const uint8_t *d = bus.device->device;
    struct usb_redir_device_connect_header connect = {
        .speed = bus.device->full_speed ? usb_redir_speed_full : usb_redir_speed_high,
        .device_class = d[4],
        .device_subclass = d[5],
        .device_protocol = d[6],
        .vendor_id = u16_at(d + 8),
        .product_id = u16_at(d + 10),
        .device_version_bcd = u16_at(d + 12),
    };

    if (bus.in)
        return;
    if (elsewhere)
        bus.last = bus.ports + (bus.last - bus.ports + 1) % REDIR_N_PORTS;
    if (!bus.last->greeted)
        return;
    bus.in = bus.last;
    send_facts(bus.device);
    usbredirparser_send_device_connect(bus.in->parser, &connect);
    bus.n_waiting = 0;
    bus.iso_runs = false;
    bus.device->plugged(true);
}

void redir_unplug(void)
{
    if (!bus.in)
        return;
    usbredirparser_send_device_disconnect(bus.in->parser);
    bus.in = NULL;
    bus.left = UINT64_MAX;
    bus.n_waiting = 0;
    bus.iso_runs = false;
    bus.device->plugged(false);
}

void redir_unplug_after(uint64_t n_bytes)
{
    bus.left = n_bytes;
}

/* How many of `len` bytes still go out; *status tells when that is not all of them. */
static size_t spend(size_t len, uint8_t *status)
{
    if (bus.left == UINT64_MAX)
        return len;
    if (bus.left < len) {
        *status = usb_redir_ioerror;
        len = (size_t)bus.left;
    }
    bus.left -= len;
    return len;
}

static void unplug_when_spent(void)
{
    if (bus.left == 0)
        redir_unplug();
}

/* ---- requests ------------------------------------------------------------------------------- */

static void on_control(void *priv, uint64_t id, struct usb_redir_control_packet_header *header,
                       uint8_t *data, int data_len)
{
    struct redir_setup setup = {
        .type = header->requesttype,
        .request = header->request,
        .value = header->value,
        .index = header->index,
        .length = header->length,
    };
    const uint8_t *bytes = data;
    struct port *port = priv;
    int len;

    if (!(setup.type & 0x80))
        setup.length = (uint16_t)data_len;
    len = port == bus.in ? redir_answer(bus.device, &setup, &bytes) : -1;
    header->status = len < 0 ? usb_redir_stall : usb_redir_success;
    if (setup.type & 0x80) {
        if (len < 0)
            len = 0;
        if (len > header->length)
            len = header->length;
        len = (int)spend((size_t)len, &header->status);
        header->length = (uint16_t)len;
        /* the library does not write to it */
        usbredirparser_send_control_packet(port->parser, id, header,
                                           len ? (uint8_t *)(uintptr_t)bytes : NULL, len);
    } else {
        usbredirparser_send_control_packet(port->parser, id, header, NULL, 0);
    }
    if (data)
        usbredirparser_free_packet_data(port->parser, data);
    unplug_when_spent();
}

static void on_set_configuration(void *priv, uint64_t id,
                                 struct usb_redir_set_configuration_header *set)
{
    const struct port *port = priv;
    struct usb_redir_configuration_status_header status = {.status = usb_redir_success,
                                                           .configuration = set->configuration};

    usbredirparser_send_configuration_status(port->parser, id, &status);
}

static void on_get_configuration(void *priv, uint64_t id)
{
    const struct port *port = priv;
    struct usb_redir_configuration_status_header status = {.status = usb_redir_success,
                                                           .configuration = 1};

    usbredirparser_send_configuration_status(port->parser, id, &status);
}

static void on_set_alt_setting(void *priv, uint64_t id,
                               struct usb_redir_set_alt_setting_header *set)
{
    const struct port *port = priv;
    struct usb_redir_alt_setting_status_header status = {
        .status = usb_redir_success, .interface = set->interface, .alt = set->alt};

    usbredirparser_send_alt_setting_status(port->parser, id, &status);
}

static void on_bulk(void *priv, uint64_t id, struct usb_redir_bulk_packet_header *header,
                    uint8_t *data, int data_len)
{
    const struct port *port = priv;
    size_t len = (size_t)header->length_high << 16 | header->length;

    if (port == bus.in && header->endpoint == bus.device->endpoint && bus.n_waiting < MAX_WAITING) {
        bus.waiting[bus.n_waiting++] = (struct request){id, len};
    } else if (port == bus.in && bus.device->out && header->endpoint == bus.device->out) {
        header->status = usb_redir_success;
        usbredirparser_send_bulk_packet(port->parser, id, header, NULL, 0);
        bus.device->came(data, (size_t)data_len);
    } else {
        header->status = usb_redir_stall;
        header->length = header->length_high = 0;
        usbredirparser_send_bulk_packet(port->parser, id, header, NULL, 0);
    }
    if (data)
        usbredirparser_free_packet_data(port->parser, data);
}

static void take_out(unsigned at)
{
    bus.n_waiting--;
    memmove(bus.waiting + at, bus.waiting + at + 1, (bus.n_waiting - at) * sizeof(*bus.waiting));
}

static void on_cancel(void *priv, uint64_t id)
{
    const struct port *port = priv;
    struct usb_redir_bulk_packet_header header = {.endpoint = bus.device->endpoint,
                                                  .status = usb_redir_cancelled};

    for (unsigned i = 0; i < bus.n_waiting; i++) {
        if (bus.waiting[i].id != id)
            continue;
        take_out(i);
        usbredirparser_send_bulk_packet(port->parser, id, &header, NULL, 0);
        return;
    }
}

unsigned redir_n_waiting(void)
{
    return bus.n_waiting;
}

size_t redir_bulk_room(void)
{
    return bus.waiting[0].len;
}

void redir_bulk_in(const uint8_t *bytes, size_t len)
{
    struct usb_redir_bulk_packet_header header = {.endpoint = bus.device->endpoint,
                                                  .status = usb_redir_success};
    uint64_t id = bus.waiting[0].id;

    len = spend(len, &header.status);
    header.length = (uint16_t)(len & 0xffff);
    header.length_high = (uint16_t)(len >> 16);
    take_out(0);
    usbredirparser_send_bulk_packet(bus.in->parser, id, &header, (uint8_t *)(uintptr_t)bytes,
                                    (int)len);
    unplug_when_spent();
}

/* ---- interrupts: there is nothing to notify of ------------------------------------------------
 */

static void tell_interrupts(const struct port *port, uint64_t id, uint8_t endpoint)
{
    struct usb_redir_interrupt_receiving_status_header status = {.status = usb_redir_success,
                                                                 .endpoint = endpoint};

    usbredirparser_send_interrupt_receiving_status(port->parser, id, &status);
}

static void on_start_interrupts(void *priv, uint64_t id,
                                struct usb_redir_start_interrupt_receiving_header *start)
{
    tell_interrupts(priv, id, start->endpoint);
}

static void on_stop_interrupts(void *priv, uint64_t id,
                               struct usb_redir_stop_interrupt_receiving_header *stop)
{
    tell_interrupts(priv, id, stop->endpoint);
}

/* ---- isochronous ------------------------------------------------------------------------------
 */

static void tell_iso(const struct port *port, uint8_t endpoint)
{
    struct usb_redir_iso_stream_status_header status = {.status = usb_redir_success,
                                                        .endpoint = endpoint};

    usbredirparser_send_iso_stream_status(port->parser, 0, &status);
}

static void on_start_iso(void *priv, uint64_t id, struct usb_redir_start_iso_stream_header *start)
{
    (void)id;
    bus.iso_runs = priv == bus.in && start->endpoint == bus.device->endpoint;
    tell_iso(priv, start->endpoint);
}

static void on_stop_iso(void *priv, uint64_t id, struct usb_redir_stop_iso_stream_header *stop)
{
    (void)id;
    if (priv == bus.in)
        bus.iso_runs = false;
    tell_iso(priv, stop->endpoint);
}

bool redir_iso_runs(void)
{
    return bus.iso_runs;
}

void redir_iso_in(const uint8_t *bytes, size_t len)
{
    struct usb_redir_iso_packet_header header = {.endpoint = bus.device->endpoint,
                                                 .status = usb_redir_success};

    if (!bus.iso_runs)
        return;
    len = spend(len, &header.status);
    header.length = (uint16_t)len;
    usbredirparser_send_iso_packet(bus.in->parser, 0, &header, (uint8_t *)(uintptr_t)bytes,
                                   (int)len);
    unplug_when_spent();
}

/* ---- the connection ---------------------------------------------------------------------------
 */

static struct usbredirparser *parser_new(struct port *port)
{
    static const int mine[] = {usb_redir_cap_connect_device_version,
                               usb_redir_cap_ep_info_max_packet_size, usb_redir_cap_64bits_ids,
                               usb_redir_cap_32bits_bulk_length,
                               usb_redir_cap_device_disconnect_ack};
    struct usbredirparser *p = usbredirparser_create();
    uint32_t caps[USB_REDIR_CAPS_SIZE] = {0};
    char name[] = "dexeld simulated device";

    if (!p)
        return NULL;
    p->priv = port;
    p->log_func = on_log;
    p->read_func = on_read;
    p->write_func = on_write;
    p->hello_func = on_hello;
    p->reset_func = on_nothing;
    p->device_disconnect_ack_func = on_nothing;
    p->control_packet_func = on_control;
    p->bulk_packet_func = on_bulk;
    p->start_iso_stream_func = on_start_iso;
    p->stop_iso_stream_func = on_stop_iso;
    p->start_interrupt_receiving_func = on_start_interrupts;
    p->stop_interrupt_receiving_func = on_stop_interrupts;
    p->cancel_data_packet_func = on_cancel;
    p->set_configuration_func = on_set_configuration;
    p->get_configuration_func = on_get_configuration;
    p->set_alt_setting_func = on_set_alt_setting;
    for (size_t i = 0; i < sizeof(mine) / sizeof(*mine); i++)
        usbredirparser_caps_set_cap(caps, mine[i]);
    usbredirparser_init(p, name, caps, USB_REDIR_CAPS_SIZE, usbredirparser_fl_usb_host);
    return p;
}

int redir_begin(const struct redir_device *device, const int fd[REDIR_N_PORTS])
{
    bus.device = device;
    for (unsigned k = 0; k < REDIR_N_PORTS; k++) {
        bus.ports[k].fd = fd[k];
        bus.ports[k].parser = parser_new(bus.ports + k);
        if (!bus.ports[k].parser)
            return -ENOMEM;
    }
    return 0;
}

void redir_end(void)
{
    for (unsigned k = 0; k < REDIR_N_PORTS; k++)
        usbredirparser_destroy(bus.ports[k].parser);
}

unsigned redir_where(void)
{
    return bus.in ? (unsigned)(bus.in - bus.ports) + 1 : 0;
}

short redir_events(unsigned port)
{
    return (short)(POLLIN |
                   (usbredirparser_has_data_to_write(bus.ports[port].parser) > 0 ? POLLOUT : 0));
}

int redir_dispatch(unsigned port, short revents)
{
    struct usbredirparser *parser = bus.ports[port].parser;

    if (revents & (POLLIN | POLLHUP) && usbredirparser_do_read(parser) == -1)
        return -1;
    if (usbredirparser_has_data_to_write(parser) && usbredirparser_do_write(parser) < 0)
        return -1;
    return 0;
}
