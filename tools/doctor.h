/*
 * What is wrong with an installation, and the command that mends it: `dexel doctor`. A topic is a
 * function of its own (doctor_NAME.c) that looks at files, and tells findings. All files lie below
 * a root, so that a test can make a machine of them; what no file tells of a real machine is told
 * there by the lines of ROOT/facts. Owned by one thread.
 */
#ifndef DX_DOCTOR_H
#define DX_DOCTOR_H

#include "daemon/config.h"

#include <glob.h>
#include <jansson.h>
#include <limits.h>
#include <sys/stat.h>

#define DX_DOCTOR_MAX_GROUPS  128
#define DX_DOCTOR_COMMAND_LEN 8192

enum dx_doctor_level {
    DX_DOCTOR_OK,
    DX_DOCTOR_WARNING, /* works, but not as well, or not for everybody */
    DX_DOCTOR_PROBLEM, /* something that is configured or attached cannot work */
    DX_DOCTOR_N_LEVELS
};

struct dx_doctor_user {
    bool known;
    char name[64];
    uid_t uid;
    gid_t gids[DX_DOCTOR_MAX_GROUPS];
    unsigned n_gids;
};

struct dx_doctor {
    const char *root;             /* "": this machine */
    const char *config_path;      /* as given, or where it was found; NULL: there is none */
    const char *socket, *control; /* that whoever asks has named; NULL: the configuration's */
    bool is_control_of_env;       /* named by $DEXELD_CONTROL */
    struct dx_config config;      /* empty unless has_config */
    bool has_config;
    bool is_missing[DX_CONFIG_MAX_STREAMS]; /* what the stream reads is not there, which was told */
    struct dx_doctor_user me;               /* groups: of this session */
    struct dx_doctor_user service;          /* groups: those it gets when it is started */
    struct dx_doctor_user running;          /* as whom it runs now */
    char pid[16];      /* of the running service, as systemd has it; "": none */
    bool answers;      /* somebody does, at the control socket */
    const char *topic; /* that tells now */
    char command[DX_DOCTOR_COMMAND_LEN];
    json_t *findings; /* an array */
    unsigned n_of[DX_DOCTOR_N_LEVELS];
};

/* ---- telling: doctor.c ------------------------------------------------------------------------
 */

/* One finding, a line; `mend` is the command to type, NULL: there is none. */
__attribute__((format(printf, 4, 5))) void dx_doctor_tell(struct dx_doctor *d,
                                                          enum dx_doctor_level level,
                                                          const char *mend, const char *fmt, ...);

/* A command: each @ of the pattern is the next word, a const char *, quoted for the shell where it
 * needs to be. It is there until the next one is made. NULL: it cannot be told. (doctor_command.c)
 */
const char *dx_doctor_command(struct dx_doctor *d, const char *pattern, ...);
/* The same of one word, for a command of dexel that asks the service: names the socket to ask at
 * where that is not the usual one. */
const char *dx_doctor_ask_command(struct dx_doctor *d, const char *pattern, const char *word);
/* Opens the configuration in an editor, and looks at it. NULL: there is none. */
const char *dx_doctor_edit_command(struct dx_doctor *d);

/* All topics, in order. */
void dx_doctor_run(struct dx_doctor *d);

/* ---- files below the root: doctor_root.c ------------------------------------------------------
 */

/* The path of a file on this machine; cut when it is too long. */
void dx_doctor_path(const struct dx_doctor *d, char *out, size_t len, const char *path);
/* The first bytes of a file, without the blanks at their end. False: it cannot be read. */
bool dx_doctor_read(const struct dx_doctor *d, const char *path, char *text, size_t len);
/* The same of the file NAME in a folder. */
bool dx_doctor_read_at(const struct dx_doctor *d, const char *folder, const char *name, char *text,
                       size_t len);
bool dx_doctor_stat(const struct dx_doctor *d, const char *path, struct stat *st);
/* How many paths match; globfree() them. dx_doctor_match gives one as seen from the root. */
size_t dx_doctor_glob(const struct dx_doctor *d, const char *pattern, glob_t *g);
const char *dx_doctor_match(const struct dx_doctor *d, const glob_t *g, size_t k);
/* The value after "KEY " in ROOT/facts. False: no test says so. */
bool dx_doctor_fact(const struct dx_doctor *d, const char *key, char *text, size_t len);
/* The value after a key at the start of a line of `text`, without blanks around. */
bool dx_doctor_line(const char *text, const char *key, char *value, size_t len);

/* ---- users and groups: doctor_users.c ---------------------------------------------------------
 */

void dx_doctor_find_users(struct dx_doctor *d);
/* As whom it runs that listens at this socket. */
void dx_doctor_find_running(struct dx_doctor *d, const char *socket);
/* False: there is no such group. */
bool dx_doctor_group(const struct dx_doctor *d, const char *name, gid_t *gid);
/* Is the user listed as a member, whatever this session has? */
bool dx_doctor_is_listed(const struct dx_doctor *d, const struct dx_doctor_user *user,
                         const char *group);
bool dx_doctor_has_gid(const struct dx_doctor_user *user, gid_t gid);
/* The name, or its number, in `text`. */
const char *dx_doctor_group_name(const struct dx_doctor *d, gid_t gid, char *text, size_t len);
/* May the user read and write what has these permissions? */
bool dx_doctor_may_open(const struct dx_doctor_user *user, const struct stat *st);

/* ---- topics ------------------------------------------------------------------------------------
 */

void dx_doctor_groups(struct dx_doctor *d);
void dx_doctor_config(struct dx_doctor *d);
void dx_doctor_streams(struct dx_doctor *d);
void dx_doctor_rules(struct dx_doctor *d);
void dx_doctor_devices(struct dx_doctor *d);
void dx_doctor_modules(struct dx_doctor *d);
void dx_doctor_usb(struct dx_doctor *d);
void dx_doctor_clocks(struct dx_doctor *d);
void dx_doctor_sockets(struct dx_doctor *d);
void dx_doctor_service(struct dx_doctor *d);
void dx_doctor_disk(struct dx_doctor *d);
void dx_doctor_limits(struct dx_doctor *d);
void dx_doctor_processor(struct dx_doctor *d);

/* ---- what several topics ask ------------------------------------------------------------------
 */

/* USB devices that have a driver here, and are attached: their folder in sysfs. `driver` NULL: all.
 */
struct dx_doctor_usb {
    const char *driver, *name;
    char folder[128], node[64], serial[64], port[32];
};
unsigned dx_doctor_usb_devices(const struct dx_doctor *d, const char *driver,
                               struct dx_doctor_usb *out, unsigned max);
/* Is the udev rule where udev reads it? */
bool dx_doctor_has_rule(const struct dx_doctor *d, char *path, size_t len);
/* How many streams are configured to use the driver. */
unsigned dx_doctor_n_streams(const struct dx_doctor *d, const char *driver);
/* The stream of that name; NULL: none is configured. */
const struct dx_stream_config *dx_doctor_stream(const struct dx_doctor *d, const char *name);
bool dx_doctor_wants_gpio(const struct dx_doctor *d);
/* Was it told of this stream that what it reads is not there? */
bool dx_doctor_is_missing(const struct dx_doctor *d, const char *stream);
/* The folder that a file lies in. */
void dx_doctor_folder(char *folder, size_t len, const char *file);
/* Where the service is asked. */
const char *dx_doctor_control_path(const struct dx_doctor *d);
/* The command that mends a socket at which nothing good answers: the service anew, or, where
 * whoever asks named the socket, the same look at those of the configuration. */
const char *dx_doctor_restart_command(struct dx_doctor *d, const char *path);
/* The service's unit. False: there is none. */
bool dx_doctor_read_unit(const struct dx_doctor *d, char *text, size_t len);
/* Do the unit and its drop-ins keep the service from the network? */
bool dx_doctor_is_offline(const struct dx_doctor *d);
/* The command that mends that. */
const char *dx_doctor_network_command(struct dx_doctor *d);
/* Who the service runs as: the user that it runs as now, else that of its unit, else who asks. */
const struct dx_doctor_user *dx_doctor_runs_as(const struct dx_doctor *d);

#endif
