/* dexel: one program, a subcommand for each job. */
#include "tools/cmd.h"
#include "tools/stdout.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>

static const struct {
    const char *name;
    char *full_name; /* the command's argv[0], so that getopt's messages begin with it */
    int (*run)(int argc, char **argv);
    const char *help;
} commands[] = {
    {"cat", "dexel cat", cmd_cat, "receive the mesh of a stream; write it to a file"},
    {"status", "dexel status", cmd_status, "show the streams and clients of a running dexeld"},
    {"metrics", "dexel metrics", cmd_metrics, "print what a running dexeld counts, for Prometheus"},
    {"clients", "dexel clients", cmd_clients, "list the subscribers of a dexeld, disconnect one"},
    {"log-level", "dexel log-level", cmd_log_level, "show or change how much a dexeld logs"},
    {"quit", "dexel quit", cmd_quit, "end a running dexeld"},
    {"devices", "dexel devices", cmd_devices, "list attached devices, as streams to configure"},
    {"doctor", "dexel doctor", cmd_doctor, "find what is wrong, and the command that mends it"},
    {"record", "dexel record", cmd_record, "start and end the recording of a stream"},
    {"replay", "dexel replay", cmd_replay, "pause, step and move the replay of a recording"},
    {"config", "dexel config", cmd_config, "print the configuration that a running dexeld has"},
    {"reload", "dexel reload", cmd_reload, "have a running dexeld read its configuration again"},
    {"mesh", "dexel mesh", cmd_mesh, "mesh a scan file without the service"},
    {"convert", "dexel convert", cmd_convert, "convert a scan to another format"},
    {"info", "dexel info", cmd_info, "tell what is in a scan or recording, and what is damaged"},
    {"sim", "dexel sim", cmd_sim, "simulate a scan of an analytic scene"},
    {"render", "dexel render", cmd_render, "draw a scan or a mesh as a PNG"},
    {"bench", "dexel bench", cmd_bench, "measure this machine"},
};

#define N_COMMANDS (sizeof(commands) / sizeof(commands[0]))

static void usage(FILE *f)
{
    fputs("usage: dexel COMMAND [OPTIONS]\n\n", f);
    for (size_t k = 0; k < N_COMMANDS; k++)
        fprintf(f, "  %-9s %s\n", commands[k].name, commands[k].help);
    fputs("\n`dexel help COMMAND` tells the options of a command.\n", f);
}

static int run(const char *name, int argc, char **argv)
{
    for (size_t k = 0; k < N_COMMANDS; k++)
        if (strcmp(name, commands[k].name) == 0) {
            argv[0] = commands[k].full_name;
            return commands[k].run(argc, argv);
        }
    fprintf(stderr, "dexel: found command '%s', expected one of:", name);
    for (size_t k = 0; k < N_COMMANDS; k++)
        fprintf(stderr, " %s", commands[k].name);
    fputc('\n', stderr);
    return 2;
}

static int dispatch(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "";

    if (strcmp(name, "--version") == 0) {
        puts("dexel " DEXELD_VERSION);
        return 0;
    }
    if (strcmp(name, "help") == 0 && argc > 2)
        return run(argv[2], 2, (char *[]){argv[2], "--help", NULL});
    if (strcmp(name, "--help") == 0 || strcmp(name, "help") == 0) {
        usage(stdout);
        return 0;
    }
    if (argc < 2) {
        usage(stderr);
        return 2;
    }
    return run(name, argc - 1, argv + 1);
}

int main(int argc, char **argv)
{
    /* A file that outgrows its limit is an error of write(), told like a full disk. */
    signal(SIGXFSZ, SIG_IGN);
    return dx_stdout_end(dispatch(argc, argv));
}
