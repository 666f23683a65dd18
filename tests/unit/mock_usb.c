/* The kernel's side of mock_usb.h. Ioctls come in the testbed's own thread, under a lock. */
#include "tests/unit/mock_usb.h"

#include "tests/unit/umock_memory.h"

#include <errno.h>
#include <linux/usbdevice_fs.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <umockdev.h>
#include <unistd.h>

#define MAX_QUEUED 64
#define N_CLAIMS   8

struct queued {
    UMockdevIoctlData *urb, *buffer;
    bool done;
};

struct mock_usb {
    struct mock_usb_device device;
    UMockdevTestbed *bed;
    bool is_beside;  /* the bed is another's */
    unsigned number; /* of the port, from 1 */
    UMockdevIoctlBase *handler;
    pthread_mutex_t lock;
    char root[256], node[64], real_node[512], sys[64];
    bool gone;
    const UMockdevIoctlClient *claims[N_CLAIMS]; /* who has the interface */
    int n_queued;
    struct queued queue[MAX_QUEUED];
};

/* Locks inside of these are not seen by ThreadSanitizer; libudev's, which umockdev uses beside
 * libusb's own thread, neither. */
__attribute__((visibility("default"))) const char *__tsan_default_suppressions(void);
const char *__tsan_default_suppressions(void)
{
    return "called_from_lib:libumockdev.so\ncalled_from_lib:libglib-2.0.so\n"
           "called_from_lib:libgobject-2.0.so\ncalled_from_lib:libgio-2.0.so\n"
           "called_from_lib:libumockdev-preload.so\ncalled_from_lib:libudev.so\n";
}

void mock_usb_wrap(char **argv)
{
    const char *preload = getenv("LD_PRELOAD"), *asan = getenv("ASAN_OPTIONS");
    char options[4096];

    if (preload && strstr(preload, "umockdev"))
        return;
    snprintf(options, sizeof(options), "%s:verify_asan_link_order=0", asan ? asan : "");
    setenv("ASAN_OPTIONS", options, 1);
    execlp("umockdev-wrapper", "umockdev-wrapper", argv[0], (char *)NULL);
    printf("no umockdev-wrapper\n");
    exit(77);
}

int mock_usb_string(const uint8_t setup[8], uint8_t *bytes, int len, const char *const *texts,
                    int n_texts)
{
    uint8_t s[255] = {4, 3, 9, 4};
    int index = setup[2], n;

    if (setup[0] != 0x80 || setup[1] != 6 || setup[3] != 3 || index > n_texts)
        return MOCK_USB_STALL;
    if (index > 0) {
        n = (int)strlen(texts[index - 1]);
        s[0] = (uint8_t)(2 + 2 * n);
        for (int k = 0; k < n; k++) {
            s[2 + 2 * k] = (uint8_t)texts[index - 1][k];
            s[3 + 2 * k] = 0;
        }
    }
    n = s[0] < len ? s[0] : len;
    memcpy(bytes, s, (size_t)n);
    return n;
}

/* What a URB transfers; HOLD leaves it queued. */
static void serve(struct mock_usb *m, struct queued *q)
{
    const struct mock_usb_device *d = &m->device;
    struct usbdevfs_urb *u = (void *)q->urb->data;
    uint8_t *bytes = q->buffer->data;
    int r;

    if (m->gone)
        r = -ESHUTDOWN;
    else if (u->type == USBDEVFS_URB_TYPE_CONTROL)
        r = d->control(d->ctx, bytes, bytes + 8, u->buffer_length - 8);
    else if (u->endpoint & 0x80)
        r = d->in(d->ctx, u->endpoint, bytes, u->buffer_length);
    else
        r = d->out(d->ctx, u->endpoint, bytes, u->buffer_length);
    q->done = r != MOCK_USB_HOLD;
    u->status = r < 0 ? r : 0;
    u->actual_length = r < 0 ? 0 : r;
}

static int submit(struct mock_usb *m, UMockdevIoctlData *arg)
{
    struct queued *q = &m->queue[m->n_queued];
    const struct usbdevfs_urb *u;

    if (m->n_queued == MAX_QUEUED)
        return ENOMEM;
    q->urb = umockdev_ioctl_data_resolve(arg, 0, sizeof(*u), NULL);
    u = (const void *)q->urb->data;
    q->buffer = umockdev_ioctl_data_resolve(q->urb, offsetof(struct usbdevfs_urb, buffer),
                                            (size_t)u->buffer_length, NULL);
    q->done = false;
    m->n_queued++;
    return 0;
}

static int discard(struct mock_usb *m, UMockdevIoctlData *arg)
{
    UMockdevIoctlData *urb = umockdev_ioctl_data_resolve(arg, 0, sizeof(struct usbdevfs_urb), NULL);
    int err = EINVAL;

    for (int k = 0; k < m->n_queued; k++)
        if (m->queue[k].urb->client_addr == urb->client_addr && !m->queue[k].done) {
            struct usbdevfs_urb *u = (void *)m->queue[k].urb->data;

            u->status = -ENOENT;
            u->actual_length = 0;
            m->queue[k].done = true;
            err = 0;
        }
    g_object_unref(urb);
    return err;
}

static int reap(struct mock_usb *m, UMockdevIoctlData *arg)
{
    int k = 0;

    for (k = 0; k < m->n_queued; k++) {
        if (!m->queue[k].done)
            serve(m, &m->queue[k]);
        if (m->queue[k].done)
            break;
    }
    if (k == m->n_queued)
        return m->gone ? ENODEV : EAGAIN;
    g_object_unref(umockdev_ioctl_data_resolve(arg, 0, sizeof(void *), NULL));
    umockdev_ioctl_data_set_ptr(umockdev_ioctl_data_resolve(arg, 0, sizeof(void *), NULL), 0,
                                m->queue[k].urb);
    g_object_unref(m->queue[k].urb);
    g_object_unref(m->queue[k].buffer);
    m->n_queued--;
    memmove(&m->queue[k], &m->queue[k + 1], (size_t)(m->n_queued - k) * sizeof(m->queue[0]));
    return 0;
}

/* An interface that another opening of the device has is busy. */
static int claim(struct mock_usb *m, const UMockdevIoctlClient *client, UMockdevIoctlData *arg,
                 bool on)
{
    UMockdevIoctlData *number = umockdev_ioctl_data_resolve(arg, 0, sizeof(unsigned), NULL);
    unsigned n = *(const unsigned *)(const void *)number->data;

    g_object_unref(number);
    if (n >= N_CLAIMS)
        return EINVAL;
    if (m->claims[n] && m->claims[n] != client)
        return EBUSY;
    m->claims[n] = on ? client : NULL;
    return 0;
}

static int answer(struct mock_usb *m, const UMockdevIoctlClient *client, gulong request,
                  UMockdevIoctlData *arg)
{
    if (m->gone && request != USBDEVFS_REAPURB && request != USBDEVFS_REAPURBNDELAY)
        return ENODEV;
    switch (request) {
    case USBDEVFS_GET_CAPABILITIES:
        *(uint32_t *)(void *)umockdev_ioctl_data_resolve(arg, 0, 4, NULL)->data = 0;
        return 0;
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_RELEASEINTERFACE:
        return claim(m, client, arg, request == USBDEVFS_CLAIMINTERFACE);
    case USBDEVFS_SETINTERFACE:
        return 0;
    case USBDEVFS_IOCTL:
    case USBDEVFS_GETDRIVER:
        return ENODATA;
    case USBDEVFS_SUBMITURB:
        return submit(m, arg);
    case USBDEVFS_DISCARDURB:
        return discard(m, arg);
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
        return reap(m, arg);
    default:
        return ENOTTY;
    }
}

/* To a thread of a testbed that runs already. It goes by locks of GLib's, and this is what shows it
 * to ThreadSanitizer. */
static void hand_over(void)
{
    static pthread_mutex_t between = PTHREAD_MUTEX_INITIALIZER;

    pthread_mutex_lock(&between);
    pthread_mutex_unlock(&between);
}

static gboolean on_ioctl(UMockdevIoctlBase *handler, UMockdevIoctlClient *client, gpointer ctx)
{
    struct mock_usb *m = ctx;
    int err;

    (void)handler;
    hand_over();
    pthread_mutex_lock(&m->lock);
    err = answer(m, client, umockdev_ioctl_client_get_request(client),
                 umockdev_ioctl_client_get_arg(client));
    pthread_mutex_unlock(&m->lock);
    umockdev_ioctl_client_complete(client, err ? -1 : 0, err);
    return TRUE;
}

static void add(struct mock_usb *m)
{
    const uint8_t *d = m->device.descriptors;
    GString *hex = g_string_new(NULL);
    char *text, *root;

    for (size_t k = 0; k < m->device.descriptors_len; k++)
        g_string_append_printf(hex, "%02X", m->device.descriptors[k]);
    snprintf(m->node, sizeof(m->node), "/dev/bus/usb/001/%03u", m->number + 1);
    snprintf(m->sys, sizeof(m->sys), "/sys/devices/pci0000:00/usb1/1-%u", m->number);
    text = g_strdup_printf(
        "P: %s\nN: %s=%s\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: BUSNUM=001\n"
        "E: DEVNUM=%03u\nE: MAJOR=189\nE: MINOR=%u\nE: DEVNAME=%s\nA: busnum=1\\n\n"
        "A: devnum=%u\\n\nA: devpath=%u\\n\nA: idVendor=%02x%02x\\n\nA: idProduct=%02x%02x\\n\n"
        "%s%s%sA: speed=480\\n\nA: bConfigurationValue=1\\n\nH: descriptors=%s\n\n",
        m->sys + strlen("/sys"), m->node + strlen("/dev/"), hex->str, m->number + 1, m->number,
        m->node, m->number + 1, m->number, d[9], d[8], d[11], d[10],
        m->device.serial ? "A: serial=" : "", m->device.serial ? m->device.serial : "",
        m->device.serial ? "\\n\n" : "", hex->str);
    if (!umockdev_testbed_add_from_string(m->bed, text, NULL))
        abort();
    root = umockdev_testbed_get_root_dir(m->bed);
    snprintf(m->root, sizeof(m->root), "%s", root);
    snprintf(m->real_node, sizeof(m->real_node), "%s%s", root, m->node);
    g_free(root);
    g_free(text);
    g_string_free(hex, TRUE);
}

/* umockdev ends a program that may not reach its sockets, so those stay open to all. */
static void forbid(struct mock_usb *m)
{
    char path[300];

    for (const char *const *p = (const char *const[]){"", "/ioctl", "/ioctl/_default", NULL}; *p;
         p++) {
        snprintf(path, sizeof(path), "%s%s", m->root, *p);
        if (chmod(path, 0777))
            abort();
    }
    if (chmod(m->real_node, 0))
        abort();
}

static struct mock_usb *attach(const struct mock_usb_device *device, struct mock_usb *beside)
{
    struct mock_usb *m = calloc(1, sizeof(*m));

    m->device = *device;
    pthread_mutex_init(&m->lock, NULL);
    m->is_beside = beside != NULL;
    m->number = beside ? 2 : 1;
    m->bed = beside ? beside->bed : umockdev_testbed_new();
    add(m);
    m->handler = umockdev_ioctl_base_new();
    g_signal_connect(m->handler, "handle-ioctl", G_CALLBACK(on_ioctl), m);
    hand_over();
    if (device->forbidden)
        forbid(m);
    else if (!umockdev_testbed_attach_ioctl(m->bed, m->node, m->handler, NULL))
        abort();
    return m;
}

struct mock_usb *mock_usb_new(const struct mock_usb_device *device)
{
    return attach(device, NULL);
}

struct mock_usb *mock_usb_new_beside(struct mock_usb *first, const struct mock_usb_device *device)
{
    return attach(device, first);
}

void mock_usb_unplug(struct mock_usb *m)
{
    pthread_mutex_lock(&m->lock);
    m->gone = true;
    pthread_mutex_unlock(&m->lock);
}

void mock_usb_free(struct mock_usb *m)
{
    if (!m->device.forbidden)
        umockdev_testbed_detach_ioctl(m->bed, m->node, NULL);
    umockdev_testbed_remove_device(m->bed, m->sys);
    g_object_unref(m->handler);
    if (!m->is_beside)
        g_object_unref(m->bed);
    /* The testbed's thread has ended, and this is what shows it to ThreadSanitizer. */
    pthread_mutex_lock(&m->lock);
    pthread_mutex_unlock(&m->lock);
    pthread_mutex_destroy(&m->lock);
    free(m);
}

void mock_usb_lock(struct mock_usb *m)
{
    pthread_mutex_lock(&m->lock);
}

void mock_usb_unlock(struct mock_usb *m)
{
    pthread_mutex_unlock(&m->lock);
}

int mock_usb_n_claimed(struct mock_usb *m)
{
    int n = 0;

    pthread_mutex_lock(&m->lock);
    for (unsigned k = 0; k < N_CLAIMS; k++)
        n += m->claims[k] != NULL;
    pthread_mutex_unlock(&m->lock);
    return n;
}

int mock_usb_n_queued(struct mock_usb *m)
{
    int n;

    pthread_mutex_lock(&m->lock);
    n = m->n_queued;
    pthread_mutex_unlock(&m->lock);
    return n;
}
