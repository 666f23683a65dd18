/* dexel devices: what is attached, which driver takes it, and the YAML to paste. */
#include "tools/args.h"
#include "tools/cmd.h"
#include "tools/devices.h"

#include <errno.h>
#include <stdio.h>

static const char help[] =
    "usage: dexel devices [--json]\n"
    "Lists the attached devices that dexeld has a driver for, as streams to paste into its\n"
    "configuration. One that this user may not open is shown with the udev rule that grants it.\n\n"
    "  --json  one JSON object on standard output\n";

int cmd_devices(int argc, char **argv)
{
    enum { OPT_JSON = 256, OPT_HELP };
    static const struct option options[] = {
        {"json", no_argument, NULL, OPT_JSON},
        {"help", no_argument, NULL, OPT_HELP},
        {0},
    };
    bool json = false;
    int opt;

    while ((opt = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (opt == OPT_HELP) {
            dx_arg_help(help);
            return 0;
        }
        if (opt != OPT_JSON)
            return 2; /* getopt has said what it did not know */
        json = true;
    }
    if (optind < argc) {
        fprintf(stderr, "dexel devices: found '%s', expected no argument\n", argv[optind]);
        return 2;
    }
    return dx_devices_print(stdout, dx_drivers, json) < 0 ? 1 : 0;
}
