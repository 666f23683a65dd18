/*
 * The common way to libusb, on a device of umockdev: choosing, permission, control and bulk
 * transfers, unplug, and nothing left open. (Isochronous: test_usb_iso.c.)
 */
#include "drivers/usb/usb_port.h"

#include "drivers/driver.h"
#include "tests/unit/mock_usb.h"

#include <dirent.h>
#include <errno.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

/* A device, one configuration: interface 0 of class 2 without endpoints, interface 1 of class 0A
 * with an interrupt endpoint, bulk IN 0x81 and bulk OUT 0x02. */
static const uint8_t descriptors[] = {18,   1, 0,    2, 0, 0,  0, 64,   0xd1,
                                      0x15, 0, 0,    1, 2, 1,  2, 3,    1,  /* 15d1:0000, 2.01 */
                                      9,    2, 48,   0, 2, 1,  0, 0x80, 50, /**/
                                      9,    4, 0,    0, 0, 2,  2, 1,    0,  /**/
                                      9,    4, 1,    0, 3, 10, 0, 0,    0,  /**/
                                      7,    5, 0x83, 3, 8, 0,  4,           /**/
                                      7,    5, 0x81, 2, 0, 2,  0,           /**/
                                      7,    5, 2,    2, 0, 2,  0};
_Static_assert(sizeof(descriptors) == 18 + 48, "configuration's total length");

static const struct dx_usb_id ids[] = {{0x045e, 0x02ae}, {0x15d1, 0x0000}, {0, 0}};

/* The device: bytes sent to it come back on 0x81; request 7 gives and takes a byte, 9 stalls. */
struct echo {
    uint8_t bytes[1 << 16];
    int n_in, n_out, max_in;
    int n_bad; /* that many IN transfers fail first */
    int bad;   /* so */
    uint8_t kept;
};

static int echo_control(void *ctx, const uint8_t setup[8], uint8_t *bytes, int len)
{
    static const char *const texts[] = {"Maker", "Range\x01 finder", "H0001234"};
    struct echo *e = ctx;

    if (setup[0] == 0x80)
        return mock_usb_string(setup, bytes, len, texts, 3);
    if (setup[1] == 8)
        return MOCK_USB_HOLD;
    if (setup[1] != 7 || len < 1)
        return MOCK_USB_STALL;
    if (setup[0] & 0x80)
        bytes[0] = e->kept;
    else
        e->kept = (uint8_t)(bytes[0] + setup[2] + setup[4]);
    return 1;
}

static int echo_in(void *ctx, uint8_t endpoint, uint8_t *bytes, int len)
{
    struct echo *e = ctx;
    int n = e->n_out - e->n_in;

    if (e->n_bad > 0) {
        e->n_bad--;
        return e->bad;
    }
    if (endpoint != 0x81 || n == 0)
        return MOCK_USB_HOLD;
    n = n > len ? len : n;
    n = e->max_in && n > e->max_in ? e->max_in : n;
    memcpy(bytes, e->bytes + e->n_in, (size_t)n);
    e->n_in += n;
    return n;
}

static int echo_out(void *ctx, uint8_t endpoint, const uint8_t *bytes, int len)
{
    struct echo *e = ctx;

    if (endpoint != 2 || e->n_out + len > (int)sizeof(e->bytes))
        return MOCK_USB_STALL;
    memcpy(e->bytes + e->n_out, bytes, (size_t)len);
    e->n_out += len;
    return len;
}

static struct echo echo;
static struct mock_usb *mock;

static int setup(void **state)
{
    (void)state;
    memset(&echo, 0, sizeof(echo));
    mock = mock_usb_new(&(struct mock_usb_device){descriptors, sizeof(descriptors), &echo,
                                                  echo_control, echo_in, echo_out, false, NULL});
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    mock_usb_free(mock);
    return 0;
}

/* Without sockets: umockdev's end of each node is one, which its thread closes when it comes to it.
 */
static int n_descriptors(void)
{
    DIR *dir = opendir("/proc/self/fd");
    char to[64];
    int n = 0;

    for (const struct dirent *e; (e = readdir(dir));) {
        ssize_t len = readlinkat(dirfd(dir), e->d_name, to, sizeof(to));

        n += len > 0 && strncmp(to, "socket:", 7) != 0;
    }
    closedir(dir);
    return n;
}

static struct dx_usb *open_it(const char *serial, const char *port)
{
    struct dx_err err = {""};
    struct dx_usb *usb = NULL;
    int r = dx_usb_open(&usb, &(struct dx_usb_want){ids, serial, port}, &err);

    if (r)
        print_message("%s\n", err.text);
    assert_int_equal(r, 0);
    return usb;
}

static void expect_none(const struct dx_usb_id *of, const char *serial, const char *port,
                        const char *text)
{
    struct dx_err err;
    struct dx_usb *usb;

    assert_int_equal(dx_usb_open(&usb, &(struct dx_usb_want){of, serial, port}, &err),
                     DX_DRIVER_E_GONE);
    assert_string_equal(err.text, text);
}

static void chooses_by_id_serial_and_port(void **state)
{
    static const struct dx_usb_id others[] = {{0x045e, 0x02ae}, {0, 0}};
    const struct dx_usb_about *about;
    struct dx_usb *usb;

    (void)state;
    expect_none(others, NULL, NULL, "no USB device 045e:02ae is there");
    expect_none(ids, "H9", "", "no USB device 045e:02ae, 15d1:0000, serial H9 is there");
    expect_none(ids, "", "1-2.3", "no USB device 045e:02ae, 15d1:0000, at port 1-2.3 is there");
    usb = open_it("H0001234", "1-1");
    about = dx_usb_tell(usb);
    assert_int_equal(about->id.vid, 0x15d1);
    assert_int_equal(about->release, 0x0201);
    assert_string_equal(about->port, "1-1");
    assert_string_equal(about->node, "/dev/bus/usb/001/002");
    assert_string_equal(about->serial, "H0001234");
    assert_string_equal(about->product, "Range? finder");
    dx_usb_close(usb);
}

static void keep(void *ctx, const struct dx_usb_about *about)
{
    *(struct dx_usb_about *)ctx = *about;
}

static void lists(void **state)
{
    struct dx_usb_about about = {.access = 1};
    struct dx_err err;

    (void)state;
    assert_int_equal(dx_usb_list(ids, keep, &about, &err), 0);
    assert_string_equal(about.serial, "H0001234");
    assert_int_equal(about.access, 0);
    memset(&about, 0, sizeof(about));
    assert_int_equal(dx_usb_list(&ids[2], keep, &about, &err), 0);
    assert_string_equal(about.port, "");
}

static void tells_no_permission_from_no_device(void **state)
{
    struct dx_usb_about about = {.access = 1};
    struct dx_usb *usb;
    struct dx_err err;
    uid_t uid = geteuid();
    int r, listed;

    (void)state;
    mock = mock_usb_new(&(struct mock_usb_device){
        .descriptors = descriptors, .descriptors_len = sizeof(descriptors), .forbidden = true});
    if (uid == 0)
        assert_int_equal(seteuid(65534), 0);
    r = dx_usb_open(&usb, &(struct dx_usb_want){ids, "H0001234", ""}, &err);
    listed = dx_usb_list(ids, keep, &about, NULL);
    if (uid == 0)
        assert_int_equal(seteuid(0), 0);
    assert_int_equal(r, -EACCES);
    assert_non_null(strstr(err.text, "/dev/bus/usb/001/002"));
    assert_non_null(strstr(err.text, "60-dexeld.rules"));
    assert_int_equal(listed, 0);
    assert_int_equal(about.access, -EACCES);
    assert_string_equal(about.port, "1-1");
}

static void claims_and_finds_endpoints(void **state)
{
    struct dx_usb *usb = open_it("", "");
    struct dx_usb_pair pair;
    struct dx_err err;
    uint8_t comm = 9;

    (void)state;
    assert_int_equal(dx_usb_find_pair(usb, 0x0a, &pair, &err), 0);
    assert_int_equal(pair.interface, 1);
    assert_int_equal(pair.in, 0x81);
    assert_int_equal(pair.out, 0x02);
    assert_int_equal(pair.in_packet_len, 512);
    assert_int_equal(dx_usb_find_interface(usb, 2, &comm), 0);
    assert_int_equal(comm, 0);
    assert_int_equal(dx_usb_find_interface(usb, 0xff, &comm), -ENOENT);
    assert_int_equal(dx_usb_find_pair(usb, 2, &pair, &err), -ENOENT);
    assert_int_equal(dx_usb_claim(usb, 0, 0, &err), 0);
    assert_int_equal(dx_usb_claim(usb, 1, 0, &err), 0);
    assert_int_equal(mock_usb_n_claimed(mock), 2);
    assert_int_equal(dx_usb_iso_packet_len(usb, 0x99, 1920), 1920);
    dx_usb_close(usb);
    assert_int_equal(mock_usb_n_claimed(mock), 0);
}

static void control_gives_takes_stalls_and_times_out(void **state)
{
    const struct dx_usb_setup put = {0x40, 7, 3, 4}, get = {0xc0, 7, 0, 0}, bad = {0xc0, 9, 0, 0},
                              slow = {0xc0, 8, 0, 0};
    struct dx_usb *usb = open_it("", "");
    uint8_t b[DX_USB_CONTROL_MAX + 1] = {10};
    struct dx_err err;
    size_t got = 99;

    (void)state;
    assert_int_equal(dx_usb_control(usb, &put, b, 1, NULL, 1000, &err), 0);
    b[0] = 0;
    assert_int_equal(dx_usb_control(usb, &get, b, 64, &got, 1000, &err), 0);
    assert_int_equal(got, 1);
    assert_int_equal(b[0], 17);
    assert_int_equal(dx_usb_control(usb, &bad, b, 1, &got, 1000, &err), -EPIPE);
    assert_non_null(strstr(err.text, "stall"));
    assert_int_equal(dx_usb_control(usb, &slow, b, 1, &got, 20, &err), -ETIMEDOUT);
    assert_int_equal(mock_usb_n_queued(mock), 0);
    assert_int_equal(dx_usb_control(usb, &get, b, sizeof(b), &got, 1000, &err), -EINVAL);
    /* The one that ran out has not harmed the next. */
    assert_int_equal(dx_usb_control(usb, &get, b, 1, &got, 1000, &err), 0);
    dx_usb_close(usb);
}

struct heap {
    uint8_t bytes[1 << 16];
    size_t len;
    unsigned n_pieces;
};

static void pile(void *ctx, const uint8_t *bytes, size_t len, int status)
{
    struct heap *h = ctx;

    assert_int_equal(status, 0);
    assert_true(h->len + len <= sizeof(h->bytes));
    memcpy(h->bytes + h->len, bytes, len);
    h->len += len;
    h->n_pieces++;
}

static struct dx_usb_stream *stream_of(struct dx_usb *usb, struct heap *heap)
{
    struct dx_usb_stream *stream = NULL;
    struct dx_err err;

    assert_int_equal(dx_usb_claim(usb, 1, 0, &err), 0);
    assert_int_equal(dx_usb_stream_open(&stream, usb,
                                        &(struct dx_usb_stream_config){.endpoint = 0x81,
                                                                       .n_transfers = 4,
                                                                       .n_packets = 1,
                                                                       .packet_len = 1024,
                                                                       .came = pile,
                                                                       .ctx = heap},
                                        &err),
                     0);
    return stream;
}

static void bulk_bytes_come_back_in_order(void **state)
{
    static uint8_t sent[3 * DX_USB_OUT_MAX + 77];
    static struct heap heap;
    struct dx_usb *usb = open_it("", "");
    struct dx_usb_stream *stream = stream_of(usb, &heap);
    struct dx_err err;

    (void)state;
    for (size_t k = 0; k < sizeof(sent); k++)
        sent[k] = (uint8_t)(k * 7 + k / 251);
    mock_usb_lock(mock);
    echo.max_in = 700;
    mock_usb_unlock(mock);
    assert_int_equal(dx_usb_write(usb, 2, sent, sizeof(sent), 5000, &err), 0);
    while (heap.len < sizeof(sent))
        assert_int_equal(dx_usb_wait(usb, 5000, &err), 0);
    assert_memory_equal(heap.bytes, sent, sizeof(sent));
    assert_int_equal(mock_usb_n_queued(mock), 4);
    dx_usb_stream_close(stream);
    assert_int_equal(mock_usb_n_queued(mock), 0);
    assert_int_equal(dx_usb_write(usb, 4, sent, 1, 1000, &err), -EPIPE);
    dx_usb_close(usb);
}

/* Some bad transfers go by; nothing but bad ones, or a stall, ends the stream. */
static void a_stream_outlives_what_is_damaged(void **state)
{
    static const struct {
        int bad, n_bad, code;
    } rows[] = {{-EPROTO, 11, 0},
                {-EPROTO, 100, -EIO},
                {-EOVERFLOW, 100, -EOVERFLOW},
                {-EPIPE, 100, -EPIPE}};

    (void)state;
    for (size_t k = 0; k < sizeof(rows) / sizeof(rows[0]); k++) {
        static struct heap heap;
        struct dx_usb *usb;
        struct dx_err err;

        usb = open_it("", "");
        heap.len = 0;
        mock_usb_lock(mock);
        echo.bad = rows[k].bad;
        echo.n_bad = rows[k].n_bad;
        mock_usb_unlock(mock);
        stream_of(usb, &heap);
        assert_int_equal(dx_usb_write(usb, 2, "abc", 3, 5000, &err), 0);
        while (heap.len < 3 && rows[k].code == 0) /* it may have come in the write */
            assert_int_equal(dx_usb_wait(usb, 10000, &err), 0);
        if (rows[k].code)
            assert_int_equal(dx_usb_wait(usb, 10000, &err), rows[k].code);
        assert_int_equal(heap.len, rows[k].code ? 0 : 3);
        dx_usb_close(usb);
        assert_int_equal(mock_usb_n_queued(mock), 0);
        mock_usb_lock(mock);
        echo.n_bad = 0;
        echo.n_in = echo.n_out;
        mock_usb_unlock(mock);
    }
}

static void *wake(void *ctx)
{
    dx_usb_wake(ctx);
    return NULL;
}

static void a_wait_ends_by_wake_or_by_time(void **state)
{
    static struct heap heap;
    struct dx_usb *usb = open_it("", "");
    struct dx_err err;
    pthread_t thread;

    (void)state;
    stream_of(usb, &heap);
    assert_int_equal(pthread_create(&thread, NULL, wake, usb), 0);
    assert_int_equal(dx_usb_wait(usb, 60000, &err), DX_DRIVER_E_AGAIN);
    pthread_join(thread, NULL);
    assert_int_equal(dx_usb_wait(usb, 5, &err), DX_DRIVER_E_AGAIN);
    assert_int_equal(heap.n_pieces, 0);
    dx_usb_close(usb); /* with its stream still open */
    assert_int_equal(mock_usb_n_queued(mock), 0);
}

static void an_unplug_is_gone_and_leaves_nothing_open(void **state)
{
    const struct dx_usb_setup get = {0xc0, 7, 0, 0};
    static struct heap heap;
    struct dx_err err;

    (void)state;
    dx_usb_close(open_it("", "")); /* what libusb and glib keep for good */
    for (int round = 0; round < 3; round++) {
        int before = n_descriptors();
        struct dx_usb *usb = open_it("", "");
        uint8_t b;

        stream_of(usb, &heap);
        if (round == 2) {
            mock_usb_unplug(mock);
            assert_int_equal(dx_usb_wait(usb, 10000, &err), DX_DRIVER_E_GONE);
            assert_non_null(strstr(err.text, "removed"));
            assert_int_equal(dx_usb_control(usb, &get, &b, 1, NULL, 1000, &err), DX_DRIVER_E_GONE);
            assert_int_equal(dx_usb_write(usb, 2, &b, 1, 1000, &err), DX_DRIVER_E_GONE);
        }
        dx_usb_close(usb);
        assert_int_equal(n_descriptors(), before);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(chooses_by_id_serial_and_port, setup, teardown),
        cmocka_unit_test_setup_teardown(lists, setup, teardown),
        cmocka_unit_test_teardown(tells_no_permission_from_no_device, teardown),
        cmocka_unit_test_setup_teardown(claims_and_finds_endpoints, setup, teardown),
        cmocka_unit_test_setup_teardown(control_gives_takes_stalls_and_times_out, setup, teardown),
        cmocka_unit_test_setup_teardown(bulk_bytes_come_back_in_order, setup, teardown),
        cmocka_unit_test_setup_teardown(a_stream_outlives_what_is_damaged, setup, teardown),
        cmocka_unit_test_setup_teardown(a_wait_ends_by_wake_or_by_time, setup, teardown),
        cmocka_unit_test_setup_teardown(an_unplug_is_gone_and_leaves_nothing_open, setup, teardown),
    };

    (void)argc;
    mock_usb_wrap(argv);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
