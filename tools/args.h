/*
 * Command line arguments: values without trailing garbage, and the terrain options that several
 * commands share. What is wrong goes to standard error in one form: "dexel mesh: --tilt: found
 * 'abc', expected degrees from 0 to 89"; the command then returns 2.
 */
#ifndef DX_ARGS_H
#define DX_ARGS_H

#include "core/grid/fit.h"
#include "core/grid/lod_level.h"
#include "core/grid/represent.h"
#include "core/grid/terrain.h"

#include <getopt.h>
#include <stdint.h>

/* Positive result: the help was asked for and printed; exit status 0. */
#define DX_ARG_E_HELP 1
int dx_arg_help(const char *text);

/* Goes through the options of argv and gives each to set(), with its name for messages ("--size",
 * "-o"). `help_value` is that of --help. 0; DX_ARG_E_HELP; -EINVAL, said by getopt or by set(). */
int dx_arg_options(int argc, char **argv, const struct option *options, int help_value,
                   const char *help,
                   int (*set)(void *ctx, int opt, const char *name, const char *text), void *ctx);

/* Where a value stands, for the message. */
struct dx_arg {
    const char *command; /* "dexel mesh" */
    const char *option;  /* "--tilt" */
    const char *text;
};

/* Says "COMMAND: OPTION: found 'TEXT', expected ...", returns -EINVAL. */
__attribute__((format(printf, 2, 3))) int dx_arg_bad(const struct dx_arg *arg, const char *expected,
                                                     ...);

/* 0, or -EINVAL having said why. `what` names the value in the message ("degrees"). */
int dx_arg_double(double *out, const struct dx_arg *arg, double min, double max, const char *what);
int dx_arg_u64(uint64_t *out, const struct dx_arg *arg, uint64_t min, uint64_t max,
               const char *what);
/* "WxH", columns x rows, each 1..DX_PLANE_MAX_SIDE. */
int dx_arg_size(uint32_t *width, uint32_t *height, const struct dx_arg *arg);
/* One to three numbers with commas; those not given are 0. Returns how many, or -EINVAL. */
int dx_arg_triple(double out[3], const struct dx_arg *arg, double min, double max,
                  const char *what);
/* Index of the text in a NULL-terminated list, or -EINVAL. */
int dx_arg_choice(const struct dx_arg *arg, const char *const *choices);

/* The name of a policy (represent.h). 0 or -EINVAL. */
int dx_arg_keep(enum dx_keep *out, const struct dx_arg *arg);

/* Of a level of detail (core/grid/lod_level.h). 0 or -EINVAL. */
int dx_arg_sigmas(double *out, const struct dx_arg *arg);
int dx_arg_stride(unsigned *out, const struct dx_arg *arg);

/* After the last option: an encoding that carries ranges (its name; NULL: none, or f32) goes with
 * neither exact points nor a level of detail. 0; -EINVAL having said why. */
int dx_encoding_args_check(const char *of_ranges, bool exact, bool has_lod, const char *command);

/* Exactly one argument that is no option: its text; NULL having said why. `what`: "a scan". */
const char *dx_arg_operand(int argc, char **argv, const char *what);

/* ---- an array of chosen size: mesh, convert, render --------------------------------------------
 */

#define DX_THIN_HELP(size)                                                                         \
    "an array of chosen size, instead of the scan's own grid:\n"                                   \
    "  " size " columns x rows over the scan's field of view\n"                                    \
    "  --keep KEEP           the sample that a dexel keeps: centre|nearest|median|mean|first\n"    \
    "                        (centre)\n"

/* 0; -EINVAL having said why. `arg` is of the option that tells the size. */
int dx_thin_args_size(struct dx_thin_options *o, const struct dx_arg *arg);
/* After the last option: a policy needs a size. `size` names its option. */
int dx_thin_args_check(const struct dx_thin_options *o, const char *command, const char *size);

/* ---- terrain options: mesh, render, bench
 * ---------------------------------------------------------- */

struct dx_terrain_args {
    struct dx_terrain_params params;
    struct dx_fit_options fit;
};

/* After the last option: exact points need a policy that keeps a sample, and (terrain not NULL)
 * frames as they are. 0; -EINVAL having said why. */
int dx_exact_args_check(bool exact, const struct dx_thin_options *thin,
                        const struct dx_terrain_args *terrain, const char *command);

enum dx_terrain_option { /* values in struct option, away from characters and the commands' own */
                         DX_OPTION_SIGMA = 0x1000,
                         DX_OPTION_TILT,
                         DX_OPTION_CAP,
                         DX_OPTION_DIAG,
                         DX_OPTION_RESCUE,
                         DX_OPTION_MIXED,
                         DX_OPTION_BRIDGE,
                         DX_OPTION_CAPS,
                         DX_OPTION_NORMALS,
                         DX_OPTION_SEAM,
                         DX_OPTION_UNIT,
                         DX_OPTION_PAPER,
                         DX_OPTION_FILTER,
                         DX_OPTION_HOLD,
                         DX_OPTION_SMOOTH,
};

/* Entries for the command's struct option table. */
#define DX_TERRAIN_OPTIONS                                                                         \
    {"sigma", required_argument, NULL, DX_OPTION_SIGMA},                                           \
        {"tilt", required_argument, NULL, DX_OPTION_TILT},                                         \
        {"cap", required_argument, NULL, DX_OPTION_CAP},                                           \
        {"diag", required_argument, NULL, DX_OPTION_DIAG},                                         \
        {"rescue", required_argument, NULL, DX_OPTION_RESCUE},                                     \
        {"mixed", required_argument, NULL, DX_OPTION_MIXED},                                       \
        {"bridge", required_argument, NULL, DX_OPTION_BRIDGE},                                     \
        {"caps", no_argument, NULL, DX_OPTION_CAPS},                                               \
        {"normals", no_argument, NULL, DX_OPTION_NORMALS},                                         \
        {"seam", required_argument, NULL, DX_OPTION_SEAM},                                         \
        {"unit", required_argument, NULL, DX_OPTION_UNIT},                                         \
        {"filter", required_argument, NULL, DX_OPTION_FILTER},                                     \
        {"hold", required_argument, NULL, DX_OPTION_HOLD},                                         \
        {"smooth", no_argument, NULL, DX_OPTION_SMOOTH},                                           \
    {                                                                                              \
        "paper", no_argument, NULL, DX_OPTION_PAPER                                                \
    }

#define DX_TERRAIN_HELP                                                                            \
    "terrain mode:\n"                                                                              \
    "  --sigma S0[,S1[,S2]]  noise of a range r: S0 + S1 r + S2 r^2, metres (estimated)\n"         \
    "  --tilt DEG            steepest incidence that is still surface (78.69)\n"                   \
    "  --cap M               longest edge, metres (none)\n"                                        \
    "  --diag fixed|short|bend\n"                                                                  \
    "                        diagonal of a cell (bend)\n"                                          \
    "  --rescue on|off       keep steep planes that the tilt would cut (on)\n"                     \
    "  --mixed off|axis|strict\n"                                                                  \
    "                        leave out samples between two surfaces (axis)\n"                      \
    "  --bridge 0|1|2        missing dexels in a row that are bridged (1)\n"                       \
    "  --caps                close the polar holes of a full turn\n"                               \
    "  --normals             a normal for each vertex\n"                                           \
    "  --seam auto|on|off    does column 0 follow the last one (auto)\n"                           \
    "  --unit M              range unit, metres (finest that holds the range in 16 bits)\n"        \
    "  --paper               length <= --cap and no other rule\n"                                  \
    "  --filter off|mean|median3  over the frames up to the one that is meshed (off)\n"            \
    "  --hold C              sigmas a dexel departs before it is taken over (0)\n"                 \
    "  --smooth              smooth ranges along the beam: vertices are no samples then\n"

void dx_terrain_args_default(struct dx_terrain_args *a);
/* `opt` is what getopt_long returned. 0; -EINVAL having said why. */
int dx_terrain_args_set(struct dx_terrain_args *a, const char *command, int opt, const char *text);
/* After the last option: do they fit together? 0; -EINVAL having said why. */
int dx_terrain_args_check(const struct dx_terrain_args *a, const char *command);

#endif
