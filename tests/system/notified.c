/*
 * notified PATH: what a service manager is told (sd_notify) at a socket of this path, each
 * assignment as a line of standard output; "listening" when the socket is there.
 */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>

int main(int argc, char **argv)
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    int fd;
    char message[4096];
    ssize_t n;

    if (argc != 2 || strlen(argv[1]) >= sizeof(addr.sun_path))
        return 2;
    strcpy(addr.sun_path, argv[1]);
    fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (fd < 0 || bind(fd, (struct sockaddr *)&addr, sizeof(addr)) < 0) {
        perror(argv[1]);
        return 1;
    }
    setvbuf(stdout, NULL, _IOLBF, 0);
    puts("listening");
    while ((n = recv(fd, message, sizeof(message) - 1, 0)) >= 0 || errno == EINTR) {
        if (n < 0)
            continue;
        message[n] = '\0';
        printf("%s%s", message, n && message[n - 1] == '\n' ? "" : "\n");
    }
    return 1;
}
