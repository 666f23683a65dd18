/*
 * gpio_edges CHIP LINE PULL N: asks the kernel for the rising edges of a line of a simulated chip,
 * pulls it up and down N times through the file PULL, and expects each edge once: numbered without
 * a gap, stamps of the monotonic clock that rise and lie between the pull and now. No library: what
 * is proved is the kernel's side.
 */
#include <errno.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#define WAIT_MS 5000

__attribute__((noreturn)) static void die(const char *what)
{
    fprintf(stderr, "gpio_edges: %s: %s\n", what, errno ? strerror(errno) : "not as expected");
    exit(1);
}

static uint64_t now_ns(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

static int request_line(const char *chip, unsigned line)
{
    struct gpio_v2_line_request request = {.offsets = {line}, .num_lines = 1};
    char path[64];
    int fd;

    snprintf(path, sizeof(path), "/dev/%s", chip);
    fd = open(path, O_RDWR | O_CLOEXEC);
    if (fd < 0)
        die(path);
    snprintf(request.consumer, sizeof(request.consumer), "gpio_edges");
    request.config.flags = GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_EDGE_RISING;
    if (ioctl(fd, GPIO_V2_GET_LINE_IOCTL, &request) < 0)
        die("the line is not given");
    close(fd);
    return request.fd;
}

static void write_pull(int fd, const char *word)
{
    if (pwrite(fd, word, strlen(word), 0) != (ssize_t)strlen(word))
        die("pull");
}

int main(int argc, char **argv)
{
    uint64_t last_ns = 0, worst_ns = 0;
    long n;
    int fd, pull;

    if (argc != 5)
        die("usage: gpio_edges CHIP LINE PULL N");
    n = strtol(argv[4], NULL, 10);
    fd = request_line(argv[1], (unsigned)strtoul(argv[2], NULL, 10));
    pull = open(argv[3], O_WRONLY);
    if (pull < 0)
        die(argv[3]);
    for (long i = 1; i <= n; i++) {
        struct gpio_v2_line_event event;
        struct pollfd p = {.fd = fd, .events = POLLIN};
        uint64_t before_ns = now_ns(), after_ns;

        write_pull(pull, "pull-up");
        errno = 0;
        if (poll(&p, 1, WAIT_MS) != 1)
            die("no edge");
        if (read(fd, &event, sizeof(event)) != (ssize_t)sizeof(event))
            die("an event");
        after_ns = now_ns();
        errno = 0;
        if (event.id != GPIO_V2_LINE_EVENT_RISING_EDGE || event.line_seqno != (uint32_t)i)
            die("the edge's number");
        if (event.timestamp_ns < before_ns || event.timestamp_ns > after_ns ||
            event.timestamp_ns <= last_ns)
            die("the edge's stamp");
        last_ns = event.timestamp_ns;
        if (after_ns - last_ns > worst_ns)
            worst_ns = after_ns - last_ns;
        write_pull(pull, "pull-down");
    }
    printf("%ld edges, seen at most %llu us after their stamps\n", n,
           (unsigned long long)worst_ns / 1000);
    return 0;
}
