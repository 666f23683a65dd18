/*
 * Lines of a simulated chip as the outside sees them: pulls them up and down, looks at their
 * levels. For programs of tests in the guest.
 */
#ifndef SIM_LINES_H
#define SIM_LINES_H

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define SIM_TRIES 5000 /* looks, a millisecond apart at the least */

static const char *sim_folder; /* of the lines: sim_gpio0, sim_gpio1 ... */

__attribute__((noreturn)) static inline void die(const char *what, const char *why)
{
    fprintf(stderr, "%s: %s\n", what, why);
    exit(1);
}

static inline void expect(bool is_so, const char *what)
{
    if (!is_so)
        die(what, "not so");
}

static inline int sim_open(unsigned line, const char *attribute, int flags)
{
    char path[256];
    int fd;

    snprintf(path, sizeof(path), "%s/sim_gpio%u/%s", sim_folder, line, attribute);
    fd = open(path, flags);
    if (fd < 0)
        die(path, strerror(errno));
    return fd;
}

static inline void sim_pull(unsigned line, bool up)
{
    const char *word = up ? "pull-up" : "pull-down";
    int fd = sim_open(line, "pull", O_WRONLY);

    if (write(fd, word, strlen(word)) != (ssize_t)strlen(word))
        die("pull", strerror(errno));
    close(fd);
}

static inline bool sim_level(unsigned line)
{
    int fd = sim_open(line, "value", O_RDONLY);
    char c = 0;

    if (read(fd, &c, 1) != 1)
        die("value", strerror(errno));
    close(fd);
    return c == '1';
}

static inline void sim_await(unsigned line, bool level, const char *what)
{
    for (int tries = 0; tries < SIM_TRIES; tries++) {
        if (sim_level(line) == level)
            return;
        poll(NULL, 0, 1);
    }
    die(what, "waited in vain");
}

#endif
