/* dexel info: what is in a file, and what of it is damaged. */
#include "tools/args.h"
#include "tools/cmd.h"
#include "tools/info.h"
#include "tools/stats_json.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static const char help[] =
    "usage: dexel info FILE [OPTIONS]\n"
    "Tells what a recording (MCAP) or a scan (PTX, PCD; of both also a directory or\n"
    "glob of files) holds, and what of it is damaged: then with exit status 1.\n\n"
    "  --json              one JSON object on standard output\n"
    "  --quick             by the index of a recording alone, without reading its data\n"
    "  --gap SECONDS       between messages of a channel, a gap is what is longer (1)\n";

enum { OPT_JSON = 256, OPT_QUICK, OPT_GAP, OPT_HELP };

static const struct option options[] = {
    {"json", no_argument, NULL, OPT_JSON},
    {"quick", no_argument, NULL, OPT_QUICK},
    {"gap", required_argument, NULL, OPT_GAP},
    {"help", no_argument, NULL, OPT_HELP},
    {0},
};

/* The first whose probe agrees; the last takes all that is left. */
static const struct dx_info_kind *const kinds[] = {&dx_info_mcap, &dx_info_folder, &dx_info_scan};

#define N_KINDS (sizeof(kinds) / sizeof(kinds[0]))

struct args {
    const char *path;
    struct dx_info_options options;
    bool json;
};

static int set_option(struct args *a, int opt, const char *text)
{
    double seconds;

    switch (opt) {
    case OPT_JSON:
        a->json = true;
        return 0;
    case OPT_QUICK:
        a->options.quick = true;
        return 0;
    case OPT_GAP:
        if (dx_arg_double(&seconds, &(struct dx_arg){"dexel info", "--gap", text}, 1e-9, 1e6,
                          "seconds") < 0)
            return -EINVAL;
        a->options.gap_ns = (uint64_t)(seconds * 1e9);
        return 0;
    default:
        return -EINVAL; /* getopt has said what it did not know */
    }
}

static int parse(struct args *a, int argc, char **argv)
{
    int opt;

    *a = (struct args){.options.gap_ns = 1000000000};
    while ((opt = getopt_long(argc, argv, "", options, NULL)) != -1) {
        if (opt == OPT_HELP)
            return dx_arg_help(help);
        if (set_option(a, opt, optarg) < 0)
            return -EINVAL;
    }
    a->path = dx_arg_operand(argc, argv, "a file");
    return a->path ? 0 : -EINVAL;
}

static const struct dx_info_kind *find_kind(const char *path)
{
    uint8_t bytes[64];
    FILE *f = fopen(path, "rb");
    size_t len = f ? fread(bytes, 1, sizeof(bytes), f) : 0;

    if (f)
        fclose(f);
    for (size_t k = 0; k + 1 < N_KINDS; k++)
        if (kinds[k]->probe(path, bytes, len))
            return kinds[k];
    return kinds[N_KINDS - 1];
}

json_t *dx_info_damage(uint64_t offset, uint64_t len, const char *text)
{
    return json_pack("{s:I, s:I, s:s}", "offset", (json_int_t)offset, "bytes", (json_int_t)len,
                     "text", text);
}

void dx_info_sound(json_t *out, uint64_t n, json_t *damage, const struct dx_info_options *o)
{
    json_object_set_new(out, "sound", n == 0 && o->quick ? json_null() : json_boolean(n == 0));
    json_object_set_new(out, "damaged", json_integer((json_int_t)n));
    json_object_set_new(out, "damage", damage);
}

/* The exit status. */
static int run(const struct args *a)
{
    json_t *object = json_object();
    struct dx_err err = {""};
    bool is_sound;
    int rc;

    json_object_set_new(object, "file", json_string(a->path));
    rc = find_kind(a->path)->tell(object, a->path, &a->options, &err);
    if (rc < 0) {
        fprintf(stderr, "dexel info: %s\n", err.text[0] ? err.text : strerror(-rc));
        json_decref(object);
        return 1;
    }
    is_sound = !json_is_false(json_object_get(object, "sound"));
    if (a->json)
        return dx_json_print(object, "dexel info") < 0 || !is_sound;
    dx_info_print(object);
    json_decref(object);
    return !is_sound;
}

int cmd_info(int argc, char **argv)
{
    struct args a;
    int rc = parse(&a, argc, argv);

    if (rc != 0)
        return rc == DX_ARG_E_HELP ? 0 : 2;
    return run(&a);
}
