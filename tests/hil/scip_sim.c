/*
 * scip_sim: a simulated SCIP 2 scanner on a pty or a TCP port, usable by hand; --help tells how. It
 * prints a line when it is ready. Stage and clock follow CLOCK_MONOTONIC, as those of dexeld do.
 */
#include "drivers/monotonic.h"
#include "tests/hil/scip_device.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <getopt.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

static struct scip_sim sim;
static const char *pty_link;
static unsigned split;     /* bytes to a write; 0: all at once */
static uint64_t unplug_at; /* bytes, counted over all: the program ends */
static uint64_t sent;

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
    SERIAL,
    HELP,
};

/* value NULL: the option takes none. */
static const struct word {
    const char *name, *value, *help;
    int code;
} words[] = {
    {"pty", "LINK", "serve a pty, whose other end becomes LINK", PTY},
    {"tcp", "PORT", "serve a TCP port; 0: a free one, which is printed", TCP},
    {"model", "NAME", "urg-04lx, ubg-05lx, utm-30lx (as it is without this), utm-30lx-ew, ust-20lx",
     MODEL},
    {"serial", "TEXT", "its serial number; \"\": it tells none", SERIAL},
    {"rpm", "R", "turns of the stage in a minute; without it the stage stands still", RPM},
    {"start", "DEG", "where the stage is when CLOCK_MONOTONIC is 0", START},
    {"swing", "DEG", "the stage goes so far and back", SWING},
    {"cw", NULL, "the stage turns clockwise, seen from above", CW},
    {"offset", "X,Y,Z", "metres: where the scanner sits, from the axis", OFFSET},
    {"angles", "ROLL,PITCH,YAW", "degrees: how it sits", ANGLES},
    {"room", "X0,Y0,Z0,X1,Y1,Z1", "metres: the room's corners, as seen from the axis", ROOM},
    {"track", "FILE", "the stage is where another program says (scip_track.h)", TRACK},
    {"skew", "PPM", "its clock runs fast by so many millionths", SKEW},
    {"clock", "MS", "what its clock says at the start", CLOCK},
    {"split", "BYTES", "send so many at a time", SPLIT},
    {"unplug", "BYTES", "end after so many", UNPLUG},
    {"bad-sum", "N", "every Nth scan has a wrong check character", BAD_SUM},
    {"bad-line", "LINE", "... in this line of its data; 1 without this", BAD_LINE},
    {"drop", "N", "every Nth byte of scans is lost", DROP},
    {"double", "N", "every Nth byte of scans comes twice", DOUBLE},
    {"codes", "N", "every Nth step has the code of an error in place of a distance", CODES},
    {"stale", NULL, "it streams when it is opened, as a program before left it", STALE},
    {"mute", NULL, "it answers nothing", MUTE},
    {"suspend", "SCAN,SCANS", "at this scan it pauses (status 21), for so many (then 98)", SUSPEND},
    {"fault", "SCAN", "at this scan its hardware fails (status 51), until it is reset", FAULT},
    {"abnormal", "SCAN", "from this scan on it answers 0L, until it is rebooted", ABNORMAL},
    {"busy", "COMMAND", "the command of this number is answered 0B, once", BUSY},
    {"no-time", NULL, "it does not know the commands TM", NO_TIME},
    {"help", NULL, "this", HELP},
};
#define N_WORDS (sizeof(words) / sizeof(words[0]))

static struct option options[N_WORDS + 1];

static void make_options(void)
{
    for (size_t k = 0; k < N_WORDS; k++)
        options[k] = (struct option){
            words[k].name, words[k].value ? required_argument : no_argument, NULL, words[k].code};
}

static void help(void)
{
    char left[48];

    puts("usage: scip_sim --pty LINK | --tcp PORT [OPTION...]\n"
         "A simulated SCIP 2 scanner in a box-shaped room. Scans, bytes and commands are counted "
         "from\n"
         "1, over all openings.\n");
    for (size_t k = 0; k < N_WORDS; k++) {
        snprintf(left, sizeof(left), "--%s %s", words[k].name,
                 words[k].value ? words[k].value : "");
        printf("  %-26s %s\n", left, words[k].help);
    }
}

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
            scip_sim_init(&sim, &scip_models[k], dx_clock_ns());
            return;
        }
    fprintf(stderr, "scip_sim: no model '%s'\n", name);
    exit(2);
}

static void take_place(int code)
{
    switch (code) {
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
    default:
        take_fault(code);
    }
}

/* The model first, for it makes everything else anew. Returns the TCP port, or -1. */
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
        case HELP:
            help();
            exit(0);
        case SERIAL:
            sim.serial = optarg[0] ? optarg : NULL;
            break;
        case SKEW:
            sim.skew = atof(optarg) * 1e-6;
            break;
        case CLOCK:
            sim.offset_ms = atoll(optarg);
            break;
        default:
            take_place(code);
        }
    if (!pty_link && port < 0) {
        fprintf(stderr, "usage: scip_sim --pty LINK | --tcp PORT [OPTION...]; see --help\n");
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
    scip_sim_sent(&sim, done);
    return true;
}

/* Serves one opening of the link. */
static void serve(int fd)
{
    uint8_t in[256];

    scip_sim_open(&sim, dx_clock_ns());
    while (!sim.gone) {
        struct pollfd p = {.fd = fd, .events = POLLIN};
        struct timespec t = {0, 0};
        uint64_t next = scip_sim_next_ns(&sim), now = dx_clock_ns();
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
                scip_sim_feed(&sim, in, (size_t)n, dx_clock_ns());
        } else if (p.revents & (POLLHUP | POLLERR)) {
            return;
        }
        scip_sim_tick(&sim, dx_clock_ns());
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
        while (sim.state == SIM_BOOTING && dx_clock_ns() < sim.until_ns)
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
        while (sim.state == SIM_BOOTING && dx_clock_ns() < sim.until_ns)
            poll(NULL, 0, 10);
    }
}

int main(int argc, char **argv)
{
    int port;

    make_options();
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
