/* The command line of dexeld. */
#ifndef DX_OPTIONS_H
#define DX_OPTIONS_H

#include "daemon/config.h"

struct dx_options {
    const char *config;             /* -c; NULL with --replay */
    struct dx_config_replay replay; /* path NULL without --replay */
    bool check;
    int ready_fd; /* a line is written here when the sockets listen; -1: none */
};

#define DX_OPTIONS_RUN (-1)

/* DX_OPTIONS_RUN, or the exit status: 0 after --help and --version, 2 having said what is wrong. */
int dx_options_parse(struct dx_options *o, int argc, char **argv);

/* The configuration that the options mean. Errors: those of dx_config_load, with text. */
int dx_options_config(struct dx_config *config, const struct dx_options *o, struct dx_err *err);

#endif
