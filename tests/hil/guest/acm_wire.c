/*
 * acm_wire TTY GADGET LIMIT: the wire between a scanner's tty and the tty of a CDC-ACM gadget, both
 * ways. When the file LIMIT holds a number, so many bytes go to the gadget from then on (it is
 * looked at when it begins, and at each SIGUSR1), and the wire is cut: it ends.
 */
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static volatile sig_atomic_t asked = 1;

static void on_signal(int number)
{
    (void)number;
    asked = 1;
}

static int open_tty(const char *path)
{
    int fd = open(path, O_RDWR | O_NOCTTY | O_CLOEXEC);

    if (fd < 0) {
        perror(path);
        exit(1);
    }
    return fd;
}

/* UINT64_MAX: no limit. */
static uint64_t read_limit(const char *path)
{
    unsigned long long n = UINT64_MAX;
    FILE *f = fopen(path, "r");

    if (f && fscanf(f, "%llu", &n) != 1)
        n = UINT64_MAX;
    if (f)
        fclose(f);
    return n;
}

/* Bytes that went on; -1: an end is gone. */
static ssize_t pass(int from, int to, uint64_t most)
{
    uint8_t bytes[512];
    ssize_t n = read(from, bytes, most < sizeof(bytes) ? (size_t)most : sizeof(bytes));

    for (ssize_t done = 0, r; n > 0 && done < n; done += r) {
        r = write(to, bytes + done, (size_t)(n - done));
        if (r < 0)
            return -1;
    }
    return n > 0 ? n : -1;
}

int main(int argc, char **argv)
{
    const struct sigaction action = {.sa_handler = on_signal, .sa_flags = SA_RESTART};
    struct pollfd p[2];
    uint64_t left = UINT64_MAX;

    if (argc != 4) {
        fprintf(stderr, "usage: acm_wire TTY GADGET LIMIT\n");
        return 2;
    }
    sigaction(SIGUSR1, &action, NULL);
    p[0] = (struct pollfd){.fd = open_tty(argv[1]), .events = POLLIN};
    p[1] = (struct pollfd){.fd = open_tty(argv[2]), .events = POLLIN};
    while (left) {
        ssize_t n = 0;

        if (asked) {
            asked = 0;
            left = read_limit(argv[3]);
        }
        if (poll(p, 2, 100) < 0)
            continue; /* the signal */
        if (p[0].revents)
            n = pass(p[0].fd, p[1].fd, left);
        if (n > 0 && left != UINT64_MAX)
            left -= (uint64_t)n;
        if (n < 0 || (p[1].revents && pass(p[1].fd, p[0].fd, UINT64_MAX) < 0))
            return 1;
    }
    return 0;
}
