/* dexeld: acquisition service. What it does is in service.c; what it was asked is in options.c. */
#include "daemon/config.h"
#include "daemon/options.h"
#include "daemon/service.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* What was printed is little, and is written here or nowhere. */
static int flush_output(struct dx_err *err)
{
    return fflush(stdout) == 0 ? 0
                               : dx_err_set(err, -errno, "standard output: %s", strerror(errno));
}

static int say_ok(const char *config, struct dx_err *err)
{
    printf("%s: ok\n", config);
    return flush_output(err);
}

static int fail(const struct dx_err *err)
{
    fprintf(stderr, "dexeld: %s\n", err->text);
    return 1;
}

int main(int argc, char **argv)
{
    struct dx_config config = {0};
    struct dx_options options;
    struct dx_err err;
    int status = dx_options_parse(&options, argc, argv);

    if (status != DX_OPTIONS_RUN)
        return flush_output(&err) < 0 ? fail(&err) : status;
    status = dx_options_config(&config, &options, &err);
    if (status == 0 && options.check)
        status = say_ok(options.config, &err);
    else if (status == 0)
        status = dx_service_run(&config, options.config, options.ready_fd, &err);
    if (status == DX_SERVICE_E_LEFT)
        _exit(0); /* a thread still uses what fini would free */
    status = status < 0 ? fail(&err) : 0;
    dx_config_fini(&config);
    return status;
}
