/* The options that all modes share, and the rows of the one that runs. */
#include "tools/cloud_args.h"
#include "tools/mesh_cloud.h"

#include <assert.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char formats[] =
    "XYZ, PTS, PLY, PCD, OBJ, STL, PTX, each plain or .gz; the returns of recordings, of clouds "
    "in\n"
    "MCAP, and of folders and globs of scans.\n\n"
    "  -o OUT              the mesh; may be left out with --stats\n"
    "  --frame N|all       of recordings, MCAP, folders and globs: which frame, from 0 (the last)\n"
    "  --topic TOPIC       of the clouds in an MCAP file (the only one)\n"
    "  --viewpoint X,Y,Z   where the points were seen from: triangles face it\n"
    "  --threads N         what can be done in parallel is (one a processor)\n"
    "  --memory MB         refuse what needs more (what the machine has free)\n"
    "  --ascii             PLY as text\n"
    "  --progress          tell how far it is, also where standard error is no "
    "terminal\n" DX_REPAIR_HELP "  --stats             one JSON object on standard output\n\n";

enum {
    OPT_MODE = 256,
    OPT_FRAME,
    OPT_TOPIC,
    OPT_VIEWPOINT,
    OPT_THREADS,
    OPT_MEMORY,
    OPT_ASCII,
    OPT_PROGRESS,
    OPT_STATS,
    OPT_HELP
};

static const struct option common[] = {
    {"mode", required_argument, NULL, OPT_MODE},
    {"frame", required_argument, NULL, OPT_FRAME},
    {"topic", required_argument, NULL, OPT_TOPIC},
    {"viewpoint", required_argument, NULL, OPT_VIEWPOINT},
    {"threads", required_argument, NULL, OPT_THREADS},
    {"memory", required_argument, NULL, OPT_MEMORY},
    {"ascii", no_argument, NULL, OPT_ASCII},
    {"progress", no_argument, NULL, OPT_PROGRESS},
    {"stats", no_argument, NULL, OPT_STATS},
    {"help", no_argument, NULL, OPT_HELP},
    DX_REPAIR_OPTIONS,
};

#define N_COMMON    (sizeof(common) / sizeof(common[0]))
#define MAX_OPTIONS 64
#define OPT_ROW     512 /* and on: the mode's rows */

/* The table for getopt_long: the common options, then the rows. */
static void make_table(struct option *table, const struct dx_mesh_option *rows)
{
    size_t n = 0;

    for (; n < N_COMMON; n++)
        table[n] = common[n];
    for (int k = 0; rows[k].name; k++) {
        assert(n < MAX_OPTIONS - 1);
        table[n++] = (struct option){rows[k].name,
                                     rows[k].kind == DX_MESH_FLAG ? no_argument : required_argument,
                                     NULL, OPT_ROW + k};
    }
    table[n] = (struct option){0};
}

static int set_row(void *config, const struct dx_mesh_option *row, const char *text)
{
    char *to = (char *)config + row->at, name[32];
    const struct dx_arg arg = {"dexel mesh", name, text};
    uint64_t n = 0;
    int k;

    snprintf(name, sizeof(name), "--%s", row->name);
    switch (row->kind) {
    case DX_MESH_NUMBER:
        return dx_arg_double((double *)to, &arg, row->min, row->max, row->what);
    case DX_MESH_COUNT:
        k = dx_arg_u64(&n, &arg, (uint64_t)row->min, (uint64_t)row->max, row->what);
        *(uint32_t *)to = (uint32_t)n;
        return k;
    case DX_MESH_CHOICE:
        k = dx_arg_choice(&arg, row->choices);
        *(int *)to = k < 0 ? 0 : k;
        return k < 0 ? k : 0;
    case DX_MESH_FLAG:
        *(bool *)to = true;
        return 0;
    case DX_MESH_TEXT:
        *(const char **)to = text;
        return 0;
    }
    return -EINVAL;
}

static int set_common(struct dx_mesh_cloud_args *a, int opt, const char *text)
{
    uint64_t n = 0;
    int rc = 0;

    switch (opt) {
    case 'o':
        a->out = text;
        break;
    case OPT_MODE:
        rc = dx_arg_choice(&(struct dx_arg){"dexel mesh", "--mode", text}, dx_mesh_mode_names());
        break;
    case OPT_FRAME:
        rc = dx_cloud_arg_frame(&a->source, &(struct dx_arg){"dexel mesh", "--frame", text});
        break;
    case OPT_TOPIC:
        a->source.topic = text;
        break;
    case OPT_VIEWPOINT:
        rc = dx_cloud_arg_viewpoint(a->viewpoint,
                                    &(struct dx_arg){"dexel mesh", "--viewpoint", text});
        a->has_viewpoint = true;
        break;
    case OPT_THREADS:
        rc = dx_arg_u64(&n, &(struct dx_arg){"dexel mesh", "--threads", text}, 1, 64, "threads");
        a->n_threads = (unsigned)n;
        break;
    case OPT_MEMORY:
        rc = dx_arg_u64(&a->memory_mb, &(struct dx_arg){"dexel mesh", "--memory", text}, 1,
                        1000000000, "megabytes");
        break;
    case OPT_ASCII:
        a->ascii = true;
        break;
    case OPT_PROGRESS:
        a->progress = true;
        break;
    case DX_OPTION_REPAIR:
    case DX_OPTION_REPAIR_HOLES:
        rc = dx_mesh_repair_args_set(&a->repair, opt, text);
        break;
    case OPT_STATS:
        a->stats = true;
        break;
    default:
        rc = -EINVAL; /* getopt_long has said so */
    }
    return rc < 0 ? rc : 0;
}

static int print_help(const struct dx_mesh_mode *mode)
{
    printf("usage: dexel mesh --mode %s IN -o OUT.{ply,obj,stl} [OPTIONS]\n"
           "Meshes unorganized points %s%s%s",
           mode->name, mode->about, formats, mode->help);
    return DX_ARG_E_HELP;
}

static int check(const struct dx_mesh_cloud_args *a)
{
    struct dx_err err;

    if (!a->out && !a->stats) {
        fprintf(stderr, "dexel mesh: found neither -o nor --stats, expected one of them\n");
        return -EINVAL;
    }
    if (a->out && !dx_mesh_writer_for(a->out, &err)) {
        fprintf(stderr, "dexel mesh: %s\n", err.text);
        return -EINVAL;
    }
    return dx_cloud_arg_check(&a->source, "dexel mesh");
}

int dx_mesh_cloud_args_parse(struct dx_mesh_cloud_args *a, const struct dx_mesh_mode *mode,
                             int argc, char **argv)
{
    struct option table[MAX_OPTIONS];
    int opt;

    *a = (struct dx_mesh_cloud_args){.mode = mode,
                                     .config = calloc(1, mode->config_len + 1),
                                     .source.frame = DX_CLOUD_READ_LAST};
    if (!a->config)
        return -ENOMEM;
    mode->defaults(a->config);
    dx_mesh_repair_args_default(&a->repair);
    make_table(table, mode->options);
    while ((opt = getopt_long(argc, argv, "o:", table, NULL)) != -1) {
        if (opt == OPT_HELP)
            return print_help(mode);
        if (opt >= OPT_ROW ? set_row(a->config, mode->options + opt - OPT_ROW, optarg) < 0
                           : set_common(a, opt, optarg) < 0)
            return -EINVAL;
    }
    a->source.path = dx_arg_operand(argc, argv, "points");
    return a->source.path ? check(a) : -EINVAL;
}

void dx_mesh_cloud_args_fini(struct dx_mesh_cloud_args *a)
{
    free(a->config);
    a->config = NULL;
}
