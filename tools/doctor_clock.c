/* Clocks: stamps of frames are as good as they are. */
#include "tools/doctor.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/timex.h>
#include <time.h>

/* A quarter of an hour: what time zones differ by. */
#define QUARTER_S 900

#define SOURCE    "/sys/devices/system/clocksource/clocksource0"

/* Does something keep the clock right? The kernel knows it of any NTP or PTP daemon. */
static bool is_synchronised(const struct dx_doctor *d)
{
    struct timex t = {0};
    char text[16];

    if (*d->root)
        return !dx_doctor_fact(d, "adjtimex", text, sizeof(text)) || atoi(text) != TIME_ERROR;
    return adjtimex(&t) != TIME_ERROR;
}

static void look_at_source(struct dx_doctor *d)
{
    static const char *const slow[] = {"hpet", "acpi_pm", "jiffies", "refined-jiffies"};
    char now[32], all[128];
    bool is_slow = false;

    if (!dx_doctor_read_at(d, SOURCE, "current_clocksource", now, sizeof(now)))
        return;
    dx_doctor_read_at(d, SOURCE, "available_clocksource", all, sizeof(all));
    for (size_t k = 0; k < sizeof(slow) / sizeof(slow[0]); k++)
        is_slow |= !strcmp(now, slow[k]);
    if (is_slow)
        dx_doctor_tell(d, DX_DOCTOR_WARNING,
                       strstr(all, "tsc") ? "echo tsc | sudo tee " SOURCE "/current_clocksource"
                                          : NULL,
                       "the clock's source is %s, which takes long to read%s", now,
                       strstr(all, "tsc") ? "" : "; there is no better one");
    else
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "the clock's source is %s", now);
}

static int64_t now_s(const struct dx_doctor *d)
{
    char text[32];

    return dx_doctor_fact(d, "now", text, sizeof(text)) ? strtoll(text, NULL, 10)
                                                        : (int64_t)time(NULL);
}

/* The clock of the board, which is taken when the machine starts: what it is off by is a jump of
 * CLOCK_REALTIME soon after. */
static void look_at_rtc(struct dx_doctor *d)
{
    char text[32];
    int64_t off, rest;

    if (!dx_doctor_read(d, "/sys/class/rtc/rtc0/since_epoch", text, sizeof(text)))
        return;
    off = strtoll(text, NULL, 10) - now_s(d);
    rest = llabs(off) % QUARTER_S;
    if (llabs(off) <= 2)
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "the board's clock is right");
    else if (rest <= 2 || rest >= QUARTER_S - 2)
        dx_doctor_tell(d, DX_DOCTOR_WARNING, "sudo timedatectl set-local-rtc 0",
                       "the board's clock is %" PRId64 " s off: it has local time, and jumps twice "
                       "a year",
                       off);
    else
        dx_doctor_tell(d, DX_DOCTOR_WARNING, "sudo hwclock --systohc",
                       "the board's clock is %" PRId64 " s off: stamps jump after a restart", off);
}

void dx_doctor_clocks(struct dx_doctor *d)
{
    if (is_synchronised(d))
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "the clock is synchronised");
    else
        dx_doctor_tell(d, DX_DOCTOR_WARNING, "sudo timedatectl set-ntp true",
                       "nothing synchronises the clock: stamps of other machines do not fit");
    look_at_source(d);
    look_at_rtc(d);
}
