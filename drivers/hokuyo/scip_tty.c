/* A scanner on a tty: the kernel's CDC-ACM driver, or a serial line. */
#include "drivers/hokuyo/scip_fd.h"

#include "drivers/udev.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

static bool find_speed(uint32_t baud, speed_t *speed)
{
    static const struct {
        uint32_t baud;
        speed_t speed;
    } known[] = {{19200, B19200},   {38400, B38400},   {57600, B57600},
                 {115200, B115200}, {230400, B230400}, {500000, B500000}};

    for (size_t k = 0; k < sizeof(known) / sizeof(known[0]); k++)
        if (known[k].baud == baud) {
            *speed = known[k].speed;
            return true;
        }
    return false;
}

/* Raw bytes, eight bits, no flow control; no other program may open it. */
static int set_up(int fd, speed_t speed)
{
    struct termios t;

    if (tcgetattr(fd, &t) < 0)
        return -errno;
    cfmakeraw(&t);
    t.c_cflag |= CLOCAL | CREAD;
    t.c_cflag &= ~(tcflag_t)(CRTSCTS | CSTOPB);
    t.c_cc[VMIN] = 1;
    t.c_cc[VTIME] = 0;
    cfsetispeed(&t, speed);
    cfsetospeed(&t, speed);
    if (tcsetattr(fd, TCSANOW, &t) < 0 || ioctl(fd, TIOCEXCL) < 0 || tcflush(fd, TCIOFLUSH) < 0)
        return -errno;
    return 0;
}

int dx_scip_link_open_tty(struct dx_scip_link **out, const char *path, uint32_t baud,
                          struct dx_err *err)
{
    speed_t speed;
    int fd, r;

    if (!find_speed(baud, &speed))
        return dx_err_set(err, -EINVAL,
                          "%s: baud %u, expected 19200, 38400, 57600, 115200, 230400 "
                          "or 500000",
                          path, baud);
    fd = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0 && (errno == ENOENT || errno == ENXIO || errno == ENODEV))
        return dx_err_set(err, DX_DRIVER_E_GONE, "%s: %s", path, strerror(errno));
    if (fd < 0)
        return dx_udev_refused(err, -errno, path);
    r = set_up(fd, speed);
    if (r) {
        close(fd);
        return dx_err_set(err, r == -EIO ? DX_DRIVER_E_GONE : r, "%s: %s", path, strerror(-r));
    }
    return dx_scip_link_new_fd(out, fd, path, err);
}
