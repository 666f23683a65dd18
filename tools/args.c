/* Values from the command line. */
#include "tools/args.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int dx_arg_help(const char *text)
{
    fputs(text, stdout);
    return DX_ARG_E_HELP;
}

int dx_arg_options(int argc, char **argv, const struct option *options, int help_value,
                   const char *help,
                   int (*set)(void *ctx, int opt, const char *name, const char *text), void *ctx)
{
    int opt, index = 0;

    while ((opt = getopt_long(argc, argv, "o:", options, &index)) != -1) {
        char name[32] = "-o";

        if (opt == help_value)
            return dx_arg_help(help);
        if (opt >= 256)
            snprintf(name, sizeof(name), "--%s", options[index].name);
        if (set(ctx, opt, name, optarg) < 0)
            return -EINVAL;
    }
    return 0;
}

int dx_arg_bad(const struct dx_arg *arg, const char *expected, ...)
{
    va_list ap;

    fprintf(stderr, "%s: %s: found '%s', expected ", arg->command, arg->option, arg->text);
    va_start(ap, expected);
    vfprintf(stderr, expected, ap);
    va_end(ap);
    fputc('\n', stderr);
    return -EINVAL;
}

/* A number up to `stop`; strtod alone would take " 1", "nan" and "0x1p3". */
static bool number(double *out, const char **text, char stop, double min, double max)
{
    char *end;

    if (!strchr("+-.0123456789", **text) || !**text || strpbrk(*text, "xXnN"))
        return false;
    *out = strtod(*text, &end);
    if (end == *text || (*end && *end != stop) || !isfinite(*out) || *out < min || *out > max)
        return false;
    *text = end;
    return true;
}

int dx_arg_double(double *out, const struct dx_arg *arg, double min, double max, const char *what)
{
    const char *p = arg->text;

    if (!number(out, &p, '\0', min, max))
        return dx_arg_bad(arg, "%s from %g to %g", what, min, max);
    return 0;
}

int dx_arg_u64(uint64_t *out, const struct dx_arg *arg, uint64_t min, uint64_t max,
               const char *what)
{
    char *end;
    unsigned long long v;

    errno = 0;
    v = strtoull(arg->text, &end, 10);
    if (arg->text[0] < '0' || arg->text[0] > '9' || *end || errno || v < min || v > max)
        return dx_arg_bad(arg, "%s from %llu to %llu", what, (unsigned long long)min,
                          (unsigned long long)max);
    *out = v;
    return 0;
}

static const char *side(uint32_t *out, const char *p)
{
    uint32_t v = 0;
    const char *start = p;

    for (; *p >= '0' && *p <= '9' && v <= DX_PLANE_MAX_SIDE; p++)
        v = 10 * v + (uint32_t)(*p - '0');
    *out = v;
    return p == start || v < 1 || v > DX_PLANE_MAX_SIDE ? NULL : p;
}

int dx_arg_size(uint32_t *width, uint32_t *height, const struct dx_arg *arg)
{
    const char *p = side(width, arg->text);

    if (p && *p == 'x')
        p = side(height, p + 1);
    else
        p = NULL;
    if (!p || *p)
        return dx_arg_bad(arg, "WIDTHxHEIGHT, each from 1 to %u", DX_PLANE_MAX_SIDE);
    return 0;
}

int dx_arg_sigmas(double *out, const struct dx_arg *arg)
{
    return dx_arg_double(out, arg, 1.0 / DX_LOD_PER_SIGMA,
                         (double)DX_LOD_MAX_BOUND / DX_LOD_PER_SIGMA, "sigmas");
}

int dx_arg_stride(unsigned *out, const struct dx_arg *arg)
{
    static const char *const strides[] = {"2", "4", "8", "16", "32", "64", NULL};
    const int k = dx_arg_choice(arg, strides);

    *out = k < 0 ? 0 : 2u << k;
    return k < 0 ? k : 0;
}

int dx_arg_triple(double out[3], const struct dx_arg *arg, double min, double max, const char *what)
{
    const char *p = arg->text;
    int n = 0;

    out[0] = out[1] = out[2] = 0;
    while (n < 3 && number(&out[n], &p, ',', min, max)) {
        n++;
        if (!*p)
            return n;
        p++;
    }
    return dx_arg_bad(arg, "one to three %s from %g to %g with commas between", what, min, max);
}

int dx_arg_choice(const struct dx_arg *arg, const char *const *choices)
{
    char list[256] = "";

    for (int k = 0; choices[k]; k++) {
        size_t len = strlen(list);

        if (strcmp(arg->text, choices[k]) == 0)
            return k;
        snprintf(list + len, sizeof(list) - len, "%s%s", k ? "|" : "", choices[k]);
    }
    return dx_arg_bad(arg, "%s", list);
}

int dx_arg_keep(enum dx_keep *out, const struct dx_arg *arg)
{
    const char *names[DX_N_KEEP + 1] = {NULL};
    int k;

    for (unsigned i = 0; i < DX_N_KEEP; i++)
        names[i] = dx_keep_name(i);
    k = dx_arg_choice(arg, names);
    *out = k < 0 ? DX_KEEP_CENTRE : (enum dx_keep)k;
    return k < 0 ? k : 0;
}

int dx_encoding_args_check(const char *of_ranges, bool exact, bool has_lod, const char *command)
{
    if (!of_ranges || (!exact && !has_lod))
        return 0;
    fprintf(stderr, "%s: --encoding: found '%s' with %s, expected f32: %s carries %s\n", command,
            of_ranges, exact ? "--exact" : "a level of detail", of_ranges,
            exact ? "ranges" : "whole cells");
    return -EINVAL;
}

const char *dx_arg_operand(int argc, char **argv, const char *what)
{
    if (optind == argc - 1)
        return argv[optind];
    if (optind >= argc)
        fprintf(stderr, "%s: found no argument, expected %s\n", argv[0], what);
    else
        fprintf(stderr, "%s: found '%s' after '%s', expected %s alone\n", argv[0], argv[optind + 1],
                argv[optind], what);
    return NULL;
}

int dx_thin_args_size(struct dx_thin_options *o, const struct dx_arg *arg)
{
    int rc = dx_arg_size(&o->width, &o->height, arg);

    if (rc == 0 && (o->width < 2 || o->height < 2 ||
                    dx_geometry_table_len(DX_MODEL_SPINNING, o->height, o->width) == 0))
        rc = dx_arg_bad(arg, "sides of 2 to %u and at most %u dexels", DX_PLANE_MAX_SIDE,
                        DX_PLANE_MAX_DEXELS);
    return rc;
}

int dx_thin_args_check(const struct dx_thin_options *o, const char *command, const char *size)
{
    if (o->width != 0 || o->keep == DX_KEEP_CENTRE)
        return 0;
    fprintf(stderr, "%s: --keep: found '%s' without %s, expected both\n", command,
            dx_keep_name(o->keep), size);
    return -EINVAL;
}

int dx_exact_args_check(bool exact, const struct dx_thin_options *thin,
                        const struct dx_terrain_args *terrain, const char *command)
{
    const char *why = NULL;

    if (!exact)
        return 0;
    if (thin->keep == DX_KEEP_MEAN)
        why = DX_EXACT_NO_MEAN;
    else if (terrain)
        why = dx_terrain_params_check_exact(&terrain->params);
    if (!why)
        return 0;
    fprintf(stderr, "%s: --exact: %s\n", command, why);
    return -EINVAL;
}

void dx_terrain_args_default(struct dx_terrain_args *a)
{
    *a = (struct dx_terrain_args){.fit = {.unit_m = 0, .seam = -1}};
    dx_terrain_params_default(&a->params);
    a->params.ingest.hold = 0; /* it spares subscribers tiles; a file has none to spare */
}

/* The options that choose a rule by a word. */
static int set_rule(struct dx_terrain_params *p, const char *command, int opt, const char *text)
{
    static const char *const diags[] = {
        [DX_DIAG_FIXED] = "fixed", [DX_DIAG_SHORT] = "short", [DX_DIAG_BEND] = "bend", NULL};
    static const char *const mixed[] = {
        [DX_MIXED_OFF] = "off", [DX_MIXED_AXIS] = "axis", [DX_MIXED_STRICT] = "strict", NULL};
    static const char *const switches[] = {"off", "on", NULL};
    static const char *const lengths[] = {"0", "1", "2", NULL};
    struct dx_arg arg = {command, "--diag", text};
    int k;

    switch (opt) {
    case DX_OPTION_DIAG:
        k = dx_arg_choice(&arg, diags);
        p->diag = k < 0 ? p->diag : (enum dx_diag)k;
        break;
    case DX_OPTION_MIXED:
        arg.option = "--mixed";
        k = dx_arg_choice(&arg, mixed);
        p->mixed = k < 0 ? p->mixed : (enum dx_mixed)k;
        break;
    case DX_OPTION_RESCUE:
        arg.option = "--rescue";
        k = dx_arg_choice(&arg, switches);
        p->rescue = k > 0;
        break;
    default:
        arg.option = "--bridge";
        k = dx_arg_choice(&arg, lengths);
        p->bridge = (uint8_t)(k < 0 ? 0 : k);
    }
    return k < 0 ? k : 0;
}

int dx_terrain_args_set(struct dx_terrain_args *a, const char *command, int opt, const char *text)
{
    static const char *const seams[] = {"auto", "off", "on", NULL};
    static const char *const filters[] = {
        [DX_FILTER_OFF] = "off", [DX_FILTER_MEAN] = "mean", [DX_FILTER_MEDIAN3] = "median3", NULL};
    int k;

    switch (opt) {
    case DX_OPTION_SIGMA:
        a->params.sigma_given = true;
        k = dx_arg_triple(a->params.sigma, &(struct dx_arg){command, "--sigma", text}, 0, 1e3,
                          "numbers");
        return k < 0 ? k : 0;
    case DX_OPTION_TILT:
        return dx_arg_double(&a->params.tilt_deg, &(struct dx_arg){command, "--tilt", text}, 0, 89,
                             "degrees");
    case DX_OPTION_CAP:
        return dx_arg_double(&a->params.cap_m, &(struct dx_arg){command, "--cap", text}, 0, 1e6,
                             "metres");
    case DX_OPTION_DIAG:
    case DX_OPTION_RESCUE:
    case DX_OPTION_MIXED:
    case DX_OPTION_BRIDGE:
        return set_rule(&a->params, command, opt, text);
    case DX_OPTION_CAPS:
        a->params.caps = true;
        return 0;
    case DX_OPTION_NORMALS:
        a->params.normals = true;
        return 0;
    case DX_OPTION_SMOOTH:
        a->params.smooth = true;
        return 0;
    case DX_OPTION_SEAM:
        k = dx_arg_choice(&(struct dx_arg){command, "--seam", text}, seams);
        a->fit.seam = k - 1;
        return k < 0 ? k : 0;
    case DX_OPTION_UNIT:
        return dx_arg_double(&a->fit.unit_m, &(struct dx_arg){command, "--unit", text}, 1e-6, 1e3,
                             "metres");
    case DX_OPTION_PAPER:
        a->params.paper = true;
        return 0;
    case DX_OPTION_FILTER:
        k = dx_arg_choice(&(struct dx_arg){command, "--filter", text}, filters);
        a->params.ingest.filter = k < 0 ? DX_FILTER_OFF : (enum dx_filter)k;
        return k < 0 ? k : 0;
    case DX_OPTION_HOLD:
        return dx_arg_double(&a->params.ingest.hold, &(struct dx_arg){command, "--hold", text}, 0,
                             100, "sigmas");
    default:
        return -EINVAL; /* getopt has said what it did not know */
    }
}

int dx_terrain_args_check(const struct dx_terrain_args *a, const char *command)
{
    const char *wrong = a->params.paper && a->params.cap_m <= 0
                            ? "--paper needs --cap"
                            : dx_terrain_params_check(&a->params);

    if (!wrong)
        return 0;
    fprintf(stderr, "%s: %s\n", command, wrong);
    return -EINVAL;
}
