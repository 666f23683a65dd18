/* dexeld: acquisition service. What it does is in service.c; what it was asked is in options.c. */
#include "daemon/config.h"
#include "daemon/options.h"
#include "daemon/service.h"

#include <stdio.h>

int main(int argc, char **argv)
{
    struct dx_config config = {0};
    struct dx_options options;
    struct dx_err err;
    int status = dx_options_parse(&options, argc, argv);

    if (status != DX_OPTIONS_RUN)
        return status;
    if (dx_options_config(&config, &options, &err) < 0 ||
        (!options.check && dx_service_run(&config, options.ready_fd, &err) < 0)) {
        fprintf(stderr, "dexeld: %s\n", err.text);
        status = 1;
    } else {
        if (options.check)
            printf("%s: ok\n", options.config);
        status = 0;
    }
    dx_config_fini(&config);
    return status;
}
