/*
 * manager WATCHDOG_MS COMMAND...: runs a service as its manager would, with $NOTIFY_SOCKET and
 * $WATCHDOG_USEC, and tells each thing that the service says on a line of standard output. From
 * READY=1 on it wants WATCHDOG=1 within the time: else it says "hung", and kills it. SIGTERM is
 * passed on, and from then on nothing is wanted. Exit status: that of the service; 3: it was
 * killed.
 */
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static _Noreturn void die(const char *what)
{
    fprintf(stderr, "manager: %s: %s\n", what, strerror(errno));
    exit(2);
}

static long now_ms(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000 + t.tv_nsec / 1000000;
}

/* A socket in the abstract namespace, with a name that the kernel chooses. */
static int open_socket(char name[64])
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    socklen_t len = sizeof(addr);
    int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);

    if (fd < 0 || bind(fd, (struct sockaddr *)&addr, sizeof(sa_family_t)) < 0 ||
        getsockname(fd, (struct sockaddr *)&addr, &len) < 0)
        die("socket");
    snprintf(name, 64, "@%.*s", (int)(len - sizeof(sa_family_t) - 1), addr.sun_path + 1);
    return fd;
}

static pid_t start(char **command, const char *watchdog_ms, const char *socket_name)
{
    char usec[64];
    sigset_t none;
    pid_t pid = fork();

    if (pid < 0)
        die("fork");
    if (pid > 0)
        return pid;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
    snprintf(usec, sizeof(usec), "%s000", watchdog_ms);
    setenv("WATCHDOG_USEC", usec, 1);
    setenv("NOTIFY_SOCKET", socket_name, 1);
    execvp(command[0], command);
    die(command[0]);
}

/* One message of the service, its lines told. Whether it is to be counted as ready or fed. */
static bool hear(int fd)
{
    char text[1024];
    ssize_t n = recv(fd, text, sizeof(text) - 1, 0);

    if (n <= 0)
        return false;
    text[n] = '\0';
    printf("%s\n", text);
    fflush(stdout);
    return !strncmp(text, "READY=1", 7) || !strncmp(text, "WATCHDOG=1", 10);
}

static int end(pid_t pid)
{
    int status;

    if (waitpid(pid, &status, 0) < 0)
        die("waitpid");
    return WIFEXITED(status) ? WEXITSTATUS(status) : 3;
}

int main(int argc, char **argv)
{
    struct signalfd_siginfo si;
    struct pollfd p[2];
    char name[64];
    long due_ms = -1, limit_ms = argc > 2 ? strtol(argv[1], NULL, 10) : 0;
    bool stops = false;
    sigset_t set;
    pid_t pid;

    if (limit_ms <= 0)
        die("usage: manager WATCHDOG_MS COMMAND...");
    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGCHLD);
    sigprocmask(SIG_BLOCK, &set, NULL);
    p[0] = (struct pollfd){open_socket(name), POLLIN, 0};
    p[1] = (struct pollfd){signalfd(-1, &set, SFD_CLOEXEC), POLLIN, 0};
    pid = start(argv + 2, argv[1], name);
    for (;;) {
        long left = due_ms < 0 ? -1 : due_ms - now_ms();

        if (poll(p, 2, (int)(due_ms < 0 ? -1 : left > 0 ? left : 0)) == 0) {
            puts("hung");
            fflush(stdout);
            kill(pid, SIGKILL);
            return end(pid);
        }
        if (p[0].revents && hear(p[0].fd) && !stops)
            due_ms = now_ms() + limit_ms;
        if (p[1].revents && read(p[1].fd, &si, sizeof(si)) == sizeof(si)) {
            if (si.ssi_signo == SIGCHLD)
                return end(pid);
            kill(pid, SIGTERM);
            stops = true;
            due_ms = -1;
        }
    }
}
