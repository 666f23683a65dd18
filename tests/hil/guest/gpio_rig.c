/*
 * gpio_rig CHIP FOLDER: interlock on line 3, laser on line 4, LED on line 5 of a simulated chip,
 * and what the driver does with them: dark by its own pull-down until the contact closes, dark at
 * once when it opens, dark at the end. Then the same in a process that is killed.
 */
#include "drivers/rig.h"
#include "tests/hil/guest/sim_lines.h"

#include <signal.h>
#include <sys/wait.h>

enum { INTERLOCK = 3, LASER = 4, LED = 5 };

static char lines[3][64];
static struct dx_rig_config config;

static struct dx_rig *open_rig(void)
{
    struct dx_err err = {""};
    struct dx_rig_status s;
    struct dx_rig *rig;

    if (dx_rig_open(&rig, &config, &err))
        die("open", err.text);
    for (int tries = 0; tries < SIM_TRIES; tries++) {
        dx_rig_tell(rig, &s);
        if (s.has_lines)
            return rig;
        poll(NULL, 0, 1);
    }
    dx_rig_trouble(rig, err.text, sizeof(err.text));
    die("lines", err.text);
}

static void drops_the_laser(void)
{
    struct dx_interlock_state state;
    struct dx_rig *rig;

    sim_pull(INTERLOCK, true);
    rig = open_rig();
    dx_rig_run(rig, true);
    expect(dx_interlock_is_open(dx_rig_interlock(rig), &state), "its own pull-down opens it");
    expect(!sim_level(LASER), "dark at first");
    sim_pull(INTERLOCK, true);
    sim_await(LASER, true, "the laser goes on");
    for (int k = 1; k <= 20; k++) {
        sim_pull(INTERLOCK, false);
        sim_await(LASER, false, "the laser goes off");
        dx_rig_interlock(rig)->state(dx_rig_interlock(rig), &state);
        expect(state.is_open && state.n_openings == (uint64_t)k, "it is open");
        sim_pull(INTERLOCK, true);
        sim_await(LASER, true, "the laser goes on again");
    }
    dx_rig_show(rig, DX_RIG_LIVE);
    sim_await(LED, true, "the LED is lit");
    dx_rig_close(rig);
    expect(!sim_level(LASER) && !sim_level(LED), "dark at the end");
}

/* Says what the chip makes of lines whose owner was killed: no promise of ours. */
static void is_killed(void)
{
    pid_t child = fork();
    int status;

    if (child == 0) {
        struct dx_rig *rig = open_rig();

        dx_rig_run(rig, true);
        sim_pull(INTERLOCK, true);
        for (;;)
            pause();
    }
    sim_await(LASER, true, "the laser goes on in another process");
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    printf("after a kill the laser's line is %s\n", sim_level(LASER) ? "as it was" : "off");
    drops_the_laser(); /* and who comes next begins dark */
}

int main(int argc, char **argv)
{
    if (argc != 3)
        die("gpio_rig", "CHIP FOLDER");
    sim_folder = argv[2];
    for (int k = 0; k < 3; k++)
        snprintf(lines[k], sizeof(lines[k]), "%s:%d", argv[1], INTERLOCK + k);
    config = (struct dx_rig_config){
        .interlock = {.line = lines[0], .active_low = true, .bias = DX_GPIO_PULL_DOWN},
        .laser = {.line = lines[1]},
        .led = {.line = lines[2]},
    };
    drops_the_laser();
    is_killed();
    return 0;
}
