/* dexeld: acquisition service. What it does is in service.c; what it was asked is in options.c. */
#include "daemon/config.h"
#include "daemon/options.h"
#include "daemon/service.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static int say_ok(const char *config, struct dx_err *err)
{
    if (printf("%s: ok\n", config) < 0 || fflush(stdout) != 0)
        return dx_err_set(err, -errno, "standard output: %s", strerror(errno));
    return 0;
}

int main(int argc, char **argv)
{
    struct dx_config config = {0};
    struct dx_options options;
    struct dx_err err;
    int status = dx_options_parse(&options, argc, argv);

    if (status != DX_OPTIONS_RUN)
        return status;
    status = dx_options_config(&config, &options, &err);
    if (status == 0 && options.check)
        status = say_ok(options.config, &err);
    else if (status == 0)
        status = dx_service_run(&config, options.config, options.ready_fd, &err);
    if (status == DX_SERVICE_E_LEFT)
        _exit(0); /* a thread still uses what fini would free */
    if (status < 0)
        fprintf(stderr, "dexeld: %s\n", err.text);
    dx_config_fini(&config);
    return status < 0 ? 1 : 0;
}
