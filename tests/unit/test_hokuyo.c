/* Blocks of scans: made of what the simulated scanner sends, decoded to frames; cut and damaged. */
#include "drivers/hokuyo/hokuyo.h"
#include "drivers/hokuyo/scip_block.h"
#include "drivers/hokuyo/scip_fd.h"
#include "tests/unit/scip_rig.h"

#include <errno.h>
#include <netinet/in.h>
#include <stdio.h>
#include <sys/socket.h>
#include <unistd.h>

struct sink {
    struct dx_geometry *geometry;
    struct dx_plane plane;
    uint64_t frame;
    uint32_t n_geometry, n_ended;
};

static int on_geometry(void *ctx, struct dx_geometry *g, uint8_t attr_bytes)
{
    struct sink *s = ctx;

    dx_geometry_unref(s->geometry);
    dx_plane_fini(&s->plane);
    s->geometry = dx_geometry_ref(g);
    s->n_geometry++;
    return dx_plane_init_for(&s->plane, g, attr_bytes);
}

static struct dx_plane *on_plane(void *ctx, uint64_t number)
{
    struct sink *s = ctx;

    s->frame = number;
    return &s->plane;
}

static void on_deliver(void *ctx, const struct dx_frame_part *part)
{
    struct sink *s = ctx;

    s->n_ended += part->last;
}

struct bench {
    struct rig rig;
    struct sink sink;
    struct dx_frame_sink to;
    struct dx_device *decoder;
    uint8_t block[64u << 10]; /* the newest */
    size_t len;
    uint64_t n_blocks;
    struct dx_err err;
};

static const struct dx_hokuyo_config plain = {.first_step = -1,
                                              .last_step = -1,
                                              .cluster = 1,
                                              .stage = {.angle = {.rpm = 60}, .columns = 20}};

static void bench_init(struct bench *b, const char *model, const struct dx_hokuyo_config *c)
{
    struct dx_scip_want want = {.intensity = c->attr_bytes > 0,
                                .echoes = c->echo != DX_HOKUYO_ECHO_ONE,
                                .first_step = (int32_t)c->first_step,
                                .last_step = (int32_t)c->last_step,
                                .cluster = c->cluster};

    memset(b, 0, sizeof(*b));
    rig_init(&b->rig, model, want);
    b->rig.sim.pose.rpm = c->stage.angle.rpm;
    b->to = (struct dx_frame_sink){&b->sink, on_geometry, on_plane, on_deliver};
    assert_int_equal(dx_hokuyo_driver.open_decoder(&b->decoder, c, &b->err), 0);
}

static void bench_fini(struct bench *b)
{
    dx_hokuyo_driver.close(b->decoder);
    dx_geometry_unref(b->sink.geometry);
    dx_plane_fini(&b->sink.plane);
    rig_fini(&b->rig);
}

/* The session's scan as a block. */
static void make_block(struct bench *b)
{
    static uint8_t room[DX_SCIP_BLOCK_HEADROOM + (64u << 10)];
    const struct dx_scip_session *s = &b->rig.session;
    uint64_t until = s->scan.host_ns + 20 * MS;
    const struct dx_angle_sample angles[2] = {
        {s->scan.host_ns, scip_sim_stage(&b->rig.sim.pose, s->scan.host_ns), false},
        {until, scip_sim_stage(&b->rig.sim.pose, until), false}};
    struct dx_scip_block head = {
        .flags = DX_SCIP_BLOCK_UNSURE,
        .status = s->scan.head.status,
        .params = s->params,
        .first = s->request.first,
        .last = s->request.last,
        .cluster = s->request.cluster,
        .skip = s->request.skip,
        .command = {(uint8_t)s->request.command[0], (uint8_t)s->request.command[1]},
        .device_ns = s->scan.device_ns,
        .host_ns = s->scan.host_ns,
        .arrival_ns = s->scan.arrival_ns,
        .serial = "H0614967"};
    const uint8_t *start;

    memcpy(room + DX_SCIP_BLOCK_HEADROOM, s->scan.bytes, s->scan.len);
    start =
        dx_scip_block_put(room + DX_SCIP_BLOCK_HEADROOM, s->scan.len, &head, angles, 2, &b->len);
    assert_true(b->len <= sizeof(b->block));
    memcpy(b->block, start, b->len);
}

/* Runs until the next scan is whole. */
static void next_block(struct bench *b)
{
    uint64_t before = b->rig.n_scans;

    while (b->rig.n_scans == before)
        rig_run(&b->rig, MS);
    make_block(b);
}

static int decode(struct bench *b, const uint8_t *bytes, size_t len)
{
    struct dx_block block = {.bytes = bytes, .len = len, .number = b->n_blocks++, .source = "sim"};

    return dx_hokuyo_driver.decode(b->decoder, &block, &b->to, &b->err);
}

/* From any block on, one block after the other, to frames of whole turns. */
static void decodes(void **state)
{
    struct bench b;

    (void)state;
    bench_init(&b, "utm-30lx", &plain);
    for (int k = 0; k < 85; k++) { /* two turns and a little */
        next_block(&b);
        assert_int_equal(decode(&b, b.block, b.len), 0);
    }
    assert_int_equal(b.sink.n_geometry, 1);
    assert_int_equal(b.sink.n_ended, 2);
    assert_int_equal(b.sink.geometry->width, 20);
    assert_int_equal(b.sink.geometry->height, 719);
    bench_fini(&b);
}

static void header_comes_back(void **state)
{
    struct dx_scip_block got;
    struct bench b;

    (void)state;
    bench_init(&b, "ust-20lx", &plain);
    next_block(&b);
    assert_int_equal(dx_scip_block_get(&got, b.block, b.len, &b.err), 0);
    assert_int_equal(got.flags, DX_SCIP_BLOCK_UNSURE);
    assert_int_equal(got.status, '9' << 8 | '9');
    assert_string_equal(got.params.model, "UST-20LX");
    assert_int_equal(got.params.class, DX_SCIP_CLASS_UTM);
    assert_int_equal(got.params.ares, 1440);
    assert_int_equal(got.params.scan_rpm, 2400);
    assert_int_equal(got.last, 1080);
    assert_memory_equal(got.command, "MD", 2);
    assert_int_equal(got.host_ns, b.rig.session.scan.host_ns);
    assert_int_equal(got.device_ns, b.rig.session.scan.device_ns);
    assert_string_equal(got.serial, "H0614967");
    assert_int_equal(got.n_angles, 2);
    assert_true(dx_scip_block_angle(&got, 1).host_ns == got.host_ns + 20 * MS);
    bench_fini(&b);
}

/* Strength, echoes and clusters: what is chosen is what the simulated room says. */
static void chooses_echoes(void **state)
{
    struct dx_hokuyo_config c = plain;
    uint16_t strength[2];
    uint32_t mm[2];

    (void)state;
    c.attr_bytes = 2;
    for (int last = 0; last < 2; last++) {
        struct bench b;
        size_t k = 0;

        c.echo = last ? DX_HOKUYO_ECHO_LAST : DX_HOKUYO_ECHO_FIRST;
        bench_init(&b, "utm-30lx-ew", &c);
        next_block(&b);
        assert_int_equal(decode(&b, b.block, b.len), 0);
        /* step 540 looks ahead; every fifth has a second echo, twice as far and stronger */
        while (!dx_plane_range(&b.sink.plane, 359 * 20 + k))
            assert_true(++k < 20);
        mm[last] = dx_plane_range(&b.sink.plane, 359 * 20 + k);
        strength[last] = (uint16_t)dx_plane_attr(&b.sink.plane, 359 * 20 + k);
        bench_fini(&b);
    }
    assert_int_equal(mm[1], 2 * mm[0]);
    assert_int_equal(strength[0], 1540);
    assert_int_equal(strength[1], 2540);
}

/* Cut anywhere, and with any byte changed: an error with a text, or the same frame; never more. */
static void damaged_blocks(void **state)
{
    struct dx_hokuyo_config c = plain;
    static uint8_t wrong[64u << 10];
    struct bench b;

    (void)state;
    c.first_step = 500;
    c.last_step = 580;
    bench_init(&b, "utm-30lx", &c);
    next_block(&b);
    assert_int_equal(decode(&b, b.block, b.len), 0);
    for (size_t len = 0; len < b.len; len++) {
        assert_int_equal(decode(&b, b.block, len), DX_DRIVER_E_CORRUPT);
        assert_non_null(strstr(b.err.text, "sim: block "));
    }
    for (size_t k = 0; k < b.len; k++) {
        int r;

        memcpy(wrong, b.block, b.len);
        wrong[k] ^= 0x55;
        r = decode(&b, wrong, b.len);
        assert_true(r == 0 || r == DX_DRIVER_E_CORRUPT);
        if (k >= DX_SCIP_BLOCK_HEADER + 2 * DX_SCIP_BLOCK_SAMPLE + 16) /* behind the echo */
            assert_int_equal(r, DX_DRIVER_E_CORRUPT);
    }
    assert_int_equal(decode(&b, b.block, b.len), 0); /* and the next good one is good */
    bench_fini(&b);
}

static void refuses_what_does_not_go_together(void **state)
{
    struct dx_hokuyo_config c = plain;
    struct dx_device *dev;
    struct dx_err err;

    (void)state;
    c.tty = (char *)"/dev/ttyACM0";
    c.tcp = (char *)"scanner";
    assert_int_equal(dx_hokuyo_driver.open(&dev, &c, &err), -EINVAL);
    c.tcp = NULL;
    c.tty = (char *)"/dev/no-such-scanner";
    c.baud = 115200;
    assert_int_equal(dx_hokuyo_driver.open(&dev, &c, &err), DX_DRIVER_E_GONE);
    assert_string_equal(err.text, "/dev/no-such-scanner: No such file or directory");
    c.baud = 115201;
    assert_int_equal(dx_hokuyo_driver.open(&dev, &c, &err), -EINVAL);
    c.baud = 115200;
    c.first_step = c.last_step = 7;
    assert_int_equal(dx_hokuyo_driver.open(&dev, &c, &err), -EINVAL);
}

/* What is no address is refused before anything is looked for. */
static void checks_addresses(void **state)
{
    static const char *const good[] = {"192.168.0.10", "host:1",          "host:65535",
                                       "[::1]",        "[fe80::1]:10940", "fe80::1"};
    static const char *const bad[] = {":",          "host:",         ":10940",  "host:0",
                                      "host:65536", "host:99999999", "host:1x", "[::1",
                                      "[::1]x",     "[::1]:",        "[]"};
    struct dx_hokuyo_config c = {.first_step = -1, .stage = {.angle = {.rpm = 1}}};
    const char *key;

    (void)state;
    for (size_t k = 0; k < sizeof(good) / sizeof(good[0]); k++) {
        c.tcp = (char *)(uintptr_t)good[k];
        assert_null(dx_hokuyo_check(&c, &key));
    }
    for (size_t k = 0; k < sizeof(bad) / sizeof(bad[0]); k++) {
        c.tcp = (char *)(uintptr_t)bad[k];
        assert_non_null(strstr(dx_hokuyo_check(&c, &key), "address"));
        assert_string_equal(key, "tcp");
    }
}

/* A link that takes nothing ends a command, and keeps nobody for long. */
static void a_full_link_ends_a_command(void **state)
{
    static const uint8_t filling[4096];
    struct dx_scip_link *link;
    struct dx_err err;
    int fds[2];

    (void)state;
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, fds), 0);
    while (write(fds[0], filling, sizeof(filling)) > 0)
        ;
    assert_int_equal(dx_scip_link_new_fd(&link, fds[0], "there", &err), 0);
    assert_int_equal(link->ops->write(link, (const uint8_t *)"QT\n", 3, &err), -ETIMEDOUT);
    assert_string_equal(err.text, "there: takes no commands");
    dx_scip_link_close(link);
    close(fds[1]);
}

/* Listens on this machine with room for nobody, so that connecting hangs. */
static int listen_full(char address[32], int filling[8])
{
    struct sockaddr_in a = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    socklen_t len = sizeof(a);

    assert_int_equal(bind(fd, (struct sockaddr *)&a, len), 0);
    assert_int_equal(listen(fd, 0), 0);
    assert_int_equal(getsockname(fd, (struct sockaddr *)&a, &len), 0);
    snprintf(address, 32, "127.0.0.1:%u", ntohs(a.sin_port));
    for (int k = 0; k < 8; k++) {
        filling[k] = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
        (void)!connect(filling[k], (struct sockaddr *)&a, len);
    }
    return fd;
}

/* A scanner that does not answer on the network is waited for, in turns that can be woken. */
static void connecting_can_be_woken(void **state)
{
    struct dx_hokuyo_config c = plain;
    struct dx_device *dev;
    struct dx_err err = {""};
    unsigned n_turns = 0;
    int filling[8], r;
    char address[32];
    int fd = listen_full(address, filling);

    (void)state;
    c.tcp = address;
    assert_int_equal(dx_hokuyo_driver.open(&dev, &c, &err), 0);
    for (int k = 0; k < 1000; k++) { /* of turns that are not woken twenty are enough */
        dx_hokuyo_driver.wake(dev);
        assert_int_equal(dx_hokuyo_driver.connect(dev, &err), DX_DRIVER_E_AGAIN);
    }
    do
        r = dx_hokuyo_driver.connect(dev, &err);
    while (r == DX_DRIVER_E_AGAIN && ++n_turns < 1000);
    assert_int_equal(r, -ETIMEDOUT);
    assert_string_equal(err.text + strlen(address), ": Connection timed out");
    dx_hokuyo_driver.close(dev);
    for (int k = 0; k < 8; k++)
        close(filling[k]);
    close(fd);
    assert_int_equal(dx_hokuyo_driver.open(&dev, &c, &err), 0);
    do
        r = dx_hokuyo_driver.connect(dev, &err);
    while (r == DX_DRIVER_E_AGAIN);
    assert_int_equal(r, -ECONNREFUSED);
    dx_hokuyo_driver.close(dev);
}

/* udev tells nothing of what is on the network. */
static void knows_where_udev_helps(void **state)
{
    struct dx_hokuyo_config c = plain;

    (void)state;
    assert_false(dx_hokuyo_driver.is_remote(&c));
    c.tcp = (char *)"";
    assert_false(dx_hokuyo_driver.is_remote(&c));
    c.tcp = (char *)"192.168.0.10";
    assert_true(dx_hokuyo_driver.is_remote(&c));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(checks_addresses),
        cmocka_unit_test(decodes),
        cmocka_unit_test(header_comes_back),
        cmocka_unit_test(chooses_echoes),
        cmocka_unit_test(damaged_blocks),
        cmocka_unit_test(refuses_what_does_not_go_together),
        cmocka_unit_test(a_full_link_ends_a_command),
        cmocka_unit_test(connecting_can_be_woken),
        cmocka_unit_test(knows_where_udev_helps),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
