/*
 * The subcommands of `dexel`. Each takes its own arguments, argv[0] being "dexel NAME", and returns
 * the exit status: 0 done, 1 the input or the service is at fault, 2 wrong usage.
 */
#ifndef DX_CMD_H
#define DX_CMD_H

int cmd_cat(int argc, char **argv);
int cmd_status(int argc, char **argv);
int cmd_metrics(int argc, char **argv);
int cmd_devices(int argc, char **argv);
int cmd_doctor(int argc, char **argv);
int cmd_mesh(int argc, char **argv);
int cmd_convert(int argc, char **argv);
int cmd_info(int argc, char **argv);
int cmd_sim(int argc, char **argv);
int cmd_render(int argc, char **argv);
int cmd_clients(int argc, char **argv);
int cmd_log_level(int argc, char **argv);
int cmd_quit(int argc, char **argv);
int cmd_record(int argc, char **argv);
int cmd_config(int argc, char **argv);
int cmd_reload(int argc, char **argv);
int cmd_replay(int argc, char **argv);
int cmd_bench(int argc, char **argv);

#endif
