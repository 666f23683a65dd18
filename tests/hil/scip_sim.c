/*
 * A simulated SCIP 2 scanner on a pty or a TCP port, usable by hand:
 *
 *   scip_sim --pty LINK | --tcp PORT  [--model utm-30lx] [--rpm R] [--start DEG] [--swing DEG]
 * [--cw]
 *            [--offset X,Y,Z] [--angles ROLL,PITCH,YAW] [faults, see below]
 *
 * LINK becomes a link to the pty's other end. PORT 0 takes a free one; the port is printed. Prints
 * a line when it is ready. Stage and clock follow CLOCK_MONOTONIC, as those of dexeld do; with
 * --track FILE the stage is where another program says (scip_track.h).
 */
#include "tests/hil/scip_device.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <getopt.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

static struct scip_sim sim;
static const char *pty_link;
static unsigned split;     /* bytes to a write; 0: all at once */
static uint64_t unplug_at; /* bytes, counted over all: the program ends */
static uint64_t sent;

static uint64_t now_ns(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

static void remove_link(void)
{
    if (pty_link)
        unlink(pty_link);
}

static void on_signal(int number)
{
    (void)number;
    if (pty_link)
        unlink(pty_link);
    _exit(0);
}

static void fail(const char *what)
{
    fprintf(stderr, "scip_sim: %s: %s\n", what, strerror(errno));
    exit(1);
}

/* ---- options ----------------------------------------------------------------------------------
 */

enum option_code {
    PTY = 256,
    TCP,
    MODEL,
    RPM,
    START,
    SWING,
    CW,
    OFFSET,
    ANGLES,
    ROOM,
    TRACK,
    SKEW,
    CLOCK,
    SPLIT,
    UNPLUG,
    BAD_SUM,
    BAD_LINE,
    DROP,
    DOUBLE,
    CODES,
    STALE,
    MUTE,
    SUSPEND,
    FAULT,
    ABNORMAL,
    BUSY,
    NO_TIME,
};

static const struct option options[] = {
    {"pty", required_argument, NULL, PTY},
    {"tcp", required_argument, NULL, TCP},
    {"model", required_argument, NULL, MODEL},
    {"rpm", required_argument, NULL, RPM},
    {"start", required_argument, NULL, START},
    {"swing", required_argument, NULL, SWING},
    {"cw", no_argument, NULL, CW},
    {"offset", required_argument, NULL, OFFSET},
    {"angles", required_argument, NULL, ANGLES},
    {"room", required_argument, NULL, ROOM}, /* X0,Y0,Z0,X1,Y1,Z1 metres */
    {"track", required_argument, NULL, TRACK},
    {"skew", required_argument, NULL, SKEW},         /* parts in a million */
    {"clock", required_argument, NULL, CLOCK},       /* the device's ms at the start */
    {"split", required_argument, NULL, SPLIT},       /* bytes to a write */
    {"unplug", required_argument, NULL, UNPLUG},     /* ends after so many bytes */
    {"bad-sum", required_argument, NULL, BAD_SUM},   /* every so many scans */
    {"bad-line", required_argument, NULL, BAD_LINE}, /* in this line of data */
    {"drop", required_argument, NULL, DROP},         /* every so many bytes */
    {"double", required_argument, NULL, DOUBLE},
    {"codes", required_argument, NULL, CODES}, /* every so many steps */
    {"stale", no_argument, NULL, STALE},
    {"mute", no_argument, NULL, MUTE},
    {"suspend", required_argument, NULL, SUSPEND},   /* SCAN,SCANS: 21, and 98 later */
    {"fault", required_argument, NULL, FAULT},       /* SCAN: 51 */
    {"abnormal", required_argument, NULL, ABNORMAL}, /* SCAN: 0L until RB */
    {"busy", required_argument, NULL, BUSY},         /* COMMAND: 0B */
    {"no-time", no_argument, NULL, NO_TIME},
    {NULL, 0, NULL, 0},
};

static void read_list(double *out, int n, const char *text)
{
    for (int k = 0; k < n; k++) {
        char *end;

        out[k] = strtod(text, &end);
        text = *end == ',' ? end + 1 : end;
    }
}

static void take_fault(int code)
{
    struct scip_faults *f = &sim.faults;
    uint64_t n = optarg ? strtoull(optarg, NULL, 10) : 0;
    const char *comma = optarg ? strchr(optarg, ',') : NULL;

    switch (code) {
    case BAD_SUM:
        f->bad_sum_every = n;
        break;
    case BAD_LINE:
        f->bad_sum_line = (unsigned)n;
        break;
    case DROP:
        f->drop_every = n;
        break;
    case DOUBLE:
        f->double_every = n;
        break;
    case CODES:
        f->code_every = (unsigned)n;
        break;
    case STALE:
        f->stale = true;
        break;
    case MUTE:
        f->mute = true;
        break;
    case SUSPEND:
        f->suspend_at = n;
        f->suspend_for = comma ? strtoull(comma + 1, NULL, 10) : 10;
        break;
    case FAULT:
        f->fault_at = n;
        break;
    case ABNORMAL:
        f->abnormal_at = n;
        break;
    case BUSY:
        f->busy_at = n;
        break;
    case NO_TIME:
        f->no_time = true;
        break;
    case SPLIT:
        split = (unsigned)n;
        break;
    case UNPLUG:
        unplug_at = n;
        break;
    default:
        exit(2);
    }
}

static void take_model(const char *name)
{
    for (size_t k = 0; k < sizeof(scip_models) / sizeof(scip_models[0]); k++)
        if (!strcmp(scip_models[k].name, name)) {
            scip_sim_init(&sim, &scip_models[k], now_ns());
            return;
        }
    fprintf(stderr, "scip_sim: no model '%s'\n", name);
    exit(2);
}

/* The model first, for it makes everything else anew. */
static int take_options(int argc, char **argv)
{
    int code, port = -1;

    take_model("utm-30lx");
    while ((code = getopt_long(argc, argv, "", options, NULL)) != -1)
        if (code == MODEL)
            take_model(optarg);
    optind = 1;
    while ((code = getopt_long(argc, argv, "", options, NULL)) != -1)
        switch (code) {
        case PTY:
            pty_link = optarg;
            break;
        case TCP:
            port = atoi(optarg);
            break;
        case MODEL:
            break;
        case RPM:
            sim.pose.rpm = atof(optarg);
            break;
        case START:
            sim.pose.start_deg = atof(optarg);
            break;
        case SWING:
            sim.pose.swing_deg = atof(optarg);
            break;
        case CW:
            sim.pose.clockwise = true;
            break;
        case OFFSET:
            read_list(sim.pose.offset, 3, optarg);
            break;
        case ANGLES:
            read_list(sim.pose.angles_deg, 3, optarg);
            break;
        case ROOM:
            read_list(sim.room, 6, optarg);
            break;
        case TRACK:
            sim.track = scip_track_map(optarg, O_RDONLY);
            if (!sim.track)
                fail(optarg);
            break;
        case SKEW:
            sim.skew = atof(optarg) * 1e-6;
            break;
        case CLOCK:
            sim.offset_ms = atoll(optarg);
            break;
        default:
            take_fault(code);
        }
    if (!pty_link && port < 0) {
        fprintf(stderr, "usage: scip_sim --pty LINK | --tcp PORT [options]\n");
        exit(2);
    }
    return port;
}

/* ---- the link ---------------------------------------------------------------------------------
 */

/* What the simulation has to say, as much as the link takes. False: the other side is gone. */
static bool flush(int fd)
{
    size_t done = 0;

    while (done < sim.out_len) {
        size_t n = sim.out_len - done;
        ssize_t r;

        if (split && n > split)
            n = split;
        if (unplug_at && sent + n > unplug_at)
            n = (size_t)(unplug_at - sent);
        r = n ? write(fd, sim.out + done, n) : 0;
        if (r < 0 && (errno == EAGAIN || errno == EINTR))
            break;
        if (r < 0)
            return false;
        done += (size_t)r;
        sent += (uint64_t)r;
        if (unplug_at && sent >= unplug_at)
            exit(0);
    }
    memmove(sim.out, sim.out + done, sim.out_len - done);
    sim.out_len -= done;
    return true;
}

/* Serves one opening of the link. */
static void serve(int fd)
{
    uint8_t in[256];

    scip_sim_open(&sim, now_ns());
    while (!sim.gone) {
        struct pollfd p = {.fd = fd, .events = POLLIN};
        struct timespec t = {0, 0};
        uint64_t next = scip_sim_next_ns(&sim), now = now_ns();
        ssize_t n;

        if (sim.out_len)
            p.events |= POLLOUT;
        t.tv_sec = next == UINT64_MAX ? 1 : 0;
        if (next != UINT64_MAX && next > now) {
            t.tv_sec = (time_t)((next - now) / 1000000000u);
            t.tv_nsec = (long)((next - now) % 1000000000u);
        }
        if (ppoll(&p, 1, &t, NULL) < 0 && errno != EINTR)
            fail("poll");
        if (p.revents & POLLIN) {
            n = read(fd, in, sizeof(in));
            if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR))
                return;
            if (n > 0)
                scip_sim_feed(&sim, in, (size_t)n, now_ns());
        } else if (p.revents & (POLLHUP | POLLERR)) {
            return;
        }
        scip_sim_tick(&sim, now_ns());
        if (!flush(fd))
            return;
    }
    flush(fd);
}

static void serve_tcp(int port)
{
    struct sockaddr_in a = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), one = 1;
    socklen_t len = sizeof(a);

    a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &one, sizeof(one));
    if (bind(fd, (struct sockaddr *)&a, sizeof(a)) < 0 || listen(fd, 1) < 0)
        fail("listen");
    getsockname(fd, (struct sockaddr *)&a, &len);
    printf("%d\n", ntohs(a.sin_port));
    fflush(stdout);
    for (;;) {
        int peer = accept4(fd, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);

        if (peer < 0)
            continue;
        serve(peer);
        close(peer);
        while (sim.state == SIM_BOOTING && now_ns() < sim.until_ns)
            poll(NULL, 0, 10);
    }
}

/* A pty has no one who opens it that could be seen: it is one opening as long as it lives. A reboot
 * makes a new one. */
static void serve_pty(void)
{
    for (;;) {
        int fd = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC), far;
        struct termios t;

        if (fd < 0 || grantpt(fd) < 0 || unlockpt(fd) < 0)
            fail("pty");
        far = open(ptsname(fd), O_RDWR | O_NOCTTY | O_CLOEXEC); /* so that it never hangs up */
        if (far < 0 || tcgetattr(far, &t) < 0)
            fail("pty");
        cfmakeraw(&t);
        tcsetattr(far, TCSANOW, &t);
        fcntl(fd, F_SETFL, O_NONBLOCK);
        unlink(pty_link);
        if (symlink(ptsname(fd), pty_link) < 0)
            fail(pty_link);
        printf("%s\n", ptsname(fd));
        fflush(stdout);
        serve(fd);
        unlink(pty_link);
        close(far);
        close(fd);
        while (sim.state == SIM_BOOTING && now_ns() < sim.until_ns)
            poll(NULL, 0, 10);
    }
}

int main(int argc, char **argv)
{
    int port;

    if (argc == 2 && !strcmp(argv[1], "--help")) {
        puts("usage: scip_sim --pty LINK | --tcp PORT [options]");
        for (const struct option *o = options; o->name; o++)
            printf("  --%s%s\n", o->name, o->has_arg ? " VALUE" : "");
        return 0;
    }
    port = take_options(argc, argv);

    signal(SIGPIPE, SIG_IGN);
    signal(SIGTERM, on_signal);
    signal(SIGINT, on_signal);
    atexit(remove_link);
    if (pty_link)
        serve_pty();
    else
        serve_tcp(port);
    return 0;
}
