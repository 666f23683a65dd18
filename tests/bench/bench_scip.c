/*
 * bench_scip [SECONDS]: the Hokuyo driver with a simulated UTM-30LX of 1081 steps, 40 scans a
 * second, over TCP on this machine, on a stage of ten turns a minute. The simulation has a thread
 * of its own, which counts in no figure.
 */
#include "tests/bench/driver_bench.h"
#include "tests/hil/scip_device.h"

#include "drivers/hokuyo/hokuyo.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

static struct scip_sim sim;
static _Atomic uint64_t sent_ns; /* when the last byte of the newest scan was sent */
static atomic_bool is_over;

static uint64_t last_byte_ns(void)
{
    return atomic_load(&sent_ns);
}

static void send_all(int fd, bool is_scan)
{
    size_t done = 0;

    if (is_scan)
        atomic_store(&sent_ns, dx_now_ns());
    while (done < sim.out_len) {
        ssize_t n = write(fd, sim.out + done, sim.out_len - done);

        if (n < 0 && errno != EAGAIN && errno != EINTR)
            break;
        done += n > 0 ? (size_t)n : 0;
    }
    sim.out_len = 0;
}

static void serve(int fd)
{
    uint8_t in[256];
    ssize_t n = 1;

    while (n != 0 && !atomic_load(&is_over)) {
        uint64_t next = scip_sim_next_ns(&sim), now = dx_now_ns();
        uint64_t left = next > now + 100000000u ? 100000000u : next > now ? next - now : 0;
        struct timespec t = {0, (long)left};
        struct pollfd p = {.fd = fd, .events = POLLIN};
        uint64_t n_scans = sim.n_scans;

        if (ppoll(&p, 1, &t, NULL) > 0) {
            n = read(fd, in, sizeof(in));
            if (n > 0)
                scip_sim_feed(&sim, in, (size_t)n, dx_now_ns());
        }
        scip_sim_tick(&sim, dx_now_ns());
        send_all(fd, sim.n_scans != n_scans);
    }
}

static void *simulate(void *listener)
{
    const int one = 1;
    int fd = accept4(*(int *)listener, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);

    if (fd < 0)
        return NULL;
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &one, sizeof(one));
    serve(fd);
    close(fd);
    return NULL;
}

static int listen_here(char address[32])
{
    struct sockaddr_in a = {.sin_family = AF_INET};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    socklen_t len = sizeof(a);

    a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (fd < 0 || bind(fd, (struct sockaddr *)&a, sizeof(a)) < 0 || listen(fd, 1) < 0 ||
        getsockname(fd, (struct sockaddr *)&a, &len) < 0) {
        perror("bench_scip");
        exit(1);
    }
    snprintf(address, 32, "127.0.0.1:%u", ntohs(a.sin_port));
    return fd;
}

int main(int argc, char **argv)
{
    static char address[32];
    static const struct dx_hokuyo_config config = {.tcp = address,
                                                   .first_step = -1,
                                                   .last_step = -1,
                                                   .cluster = 1,
                                                   .stage = {.angle = {.rpm = 10}}};
    static struct driver_bench b = {.name = "Hokuyo UTM-30LX, 1081 steps",
                                    .driver = &dx_hokuyo_driver,
                                    .config = &config,
                                    .hz = 40,
                                    .last_byte_ns = last_byte_ns};
    int listener = listen_here(address), r;
    pthread_t thread;

    scip_sim_init(&sim, &scip_models[2], dx_now_ns());
    if (pthread_create(&thread, NULL, simulate, &listener) != 0)
        return 1;
    r = driver_bench_run(&b, driver_bench_seconds(argc, argv));
    atomic_store(&is_over, true);
    pthread_join(thread, NULL);
    close(listener);
    return r;
}
