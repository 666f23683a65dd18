/* What `dexel cat` was asked for: the subscription, and what to do with what comes. */
#ifndef DX_CAT_ARGS_H
#define DX_CAT_ARGS_H

#include "client/dexel.h"

#include <stdbool.h>
#include <stdint.h>

struct dx_cat_args {
    struct dexel_options subscribe; /* texts are argv's */
    const char *out;                /* NULL: none */
    uint64_t n_frames;              /* 0: no limit */
    double timeout_s;               /* 0: none */
    bool every, split, world, stats, quiet;
};

/* 0; DX_ARG_E_HELP having printed the help; -EINVAL having said what is wrong. */
int dx_cat_args_parse(struct dx_cat_args *cat, int argc, char **argv);

#endif
