/* Pacing: a wait on an eventfd until the frame's due time. */
#include "drivers/replay.h"

#include "drivers/driver.h"
#include "drivers/monotonic.h"

#include <errno.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#define NS_PER_S 1000000000u
#define LOOK_NS  500000000u /* its caller can show that it lives */

int dx_pace_init(struct dx_pace *p, double rate)
{
    *p = (struct dx_pace){.rate = rate, .wake_fd = -1};
    if (!(rate >= 0))
        return -EINVAL;
    p->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    return p->wake_fd < 0 ? -errno : 0;
}

void dx_pace_fini(struct dx_pace *p)
{
    if (p->wake_fd >= 0)
        close(p->wake_fd);
    p->wake_fd = -1;
}

/* When `stamp_ns` is due on the host's clock. */
static uint64_t due(const struct dx_pace *p, uint64_t stamp_ns)
{
    double after;

    if (p->rate == 0 || stamp_ns <= p->stamp0_ns)
        return 0;
    after = (double)(stamp_ns - p->stamp0_ns) / p->rate;
    return after < 9e18 ? p->start_ns + (uint64_t)after : UINT64_MAX;
}

/* Waits for a wake, at most so long. 0: the time is over; DX_DRIVER_E_AGAIN woken. */
static int wait_ns(struct dx_pace *p, uint64_t ns)
{
    const struct timespec t = {(time_t)(ns / NS_PER_S), (long)(ns % NS_PER_S)};
    struct pollfd fd = {.fd = p->wake_fd, .events = POLLIN};
    int n = ppoll(&fd, 1, &t, NULL);
    uint64_t count;

    if (n < 0)
        return errno == EINTR ? 0 : -errno;
    if (n == 0)
        return 0;
    /* an empty eventfd (EAGAIN) means that it was taken already: a wake all the same */
    (void)!read(p->wake_fd, &count, sizeof(count));
    return DX_DRIVER_E_AGAIN;
}

int dx_pace_idle(struct dx_pace *p)
{
    int rc = wait_ns(p, LOOK_NS);

    return rc < 0 ? rc : DX_DRIVER_E_AGAIN;
}

int dx_pace_wait(struct dx_pace *p, uint64_t stamp_ns)
{
    uint64_t now = dx_clock_ns(), until, look = now + LOOK_NS;
    int rc;

    if (p->start_ns == 0) {
        p->start_ns = now;
        p->stamp0_ns = stamp_ns;
    }
    until = due(p, stamp_ns);
    do {
        uint64_t next = until < look ? until : look;

        rc = wait_ns(p, next > now ? next - now : 0);
        now = dx_clock_ns();
    } while (rc == 0 && now < until && now < look);
    return rc == 0 && now < until ? DX_DRIVER_E_AGAIN : rc;
}

void dx_pace_wake(struct dx_pace *p)
{
    uint64_t one = 1;

    (void)!write(p->wake_fd, &one, sizeof(one));
}

void dx_pace_restart(struct dx_pace *p)
{
    p->start_ns = 0;
}
