/*
 * The modes that mesh unorganized points, as rows of a table: dexel mesh --mode NAME. All share one
 * front end (mesh_cloud.c): it takes the options, reads and cleans the points, finds their spacing
 * and noise, calls the mode, writes the mesh and tells the numbers. A mode is one file,
 * tools/mesh_mode_NAME.c, and knows nothing of files and options.
 *
 * To add one:
 *  1. Write mesh_mode_NAME.c with `const struct dx_mesh_mode dx_mesh_mode_NAME`: a struct of its
 *     parameters, the rows that set them, defaults() and run(). mesh_mode_project.c is the example.
 *     A parameter that is found from the data has a default that says "not given" (0, say): run()
 *     finds it from job->spacing and job->noise, and tells what it took by dx_mesh_job_tell().
 *  2. Declare it below and put it into the table of mesh_modes.c.
 *  3. Describe its options in docs/dexel-mesh.1: tests/tree/man.sh looks for each row's name there.
 *
 * One thread calls run(); it may use job->pool, but all functions below are the caller's alone.
 */
#ifndef DX_MESH_MODE_H
#define DX_MESH_MODE_H

#include "core/cloud/cloud.h"
#include "tools/cloud_mesh.h"

#include <jansson.h>

/* What an option sets, `at` bytes into the mode's parameters. */
enum dx_mesh_kind {
    DX_MESH_NUMBER, /* double, min to max */
    DX_MESH_COUNT,  /* uint32_t, min to max */
    DX_MESH_CHOICE, /* int: which of `choices` */
    DX_MESH_FLAG,   /* bool, without a value: true */
    DX_MESH_TEXT,   /* const char *, as it stands; run() checks it and returns -EINVAL */
};

struct dx_mesh_option {
    const char *name; /* without dashes */
    enum dx_mesh_kind kind;
    size_t at;
    double min, max;
    const char *what;           /* of a number or count, for errors: "degrees" */
    const char *const *choices; /* ends with NULL */
};

/* What run() works on and gives to. Lengths are in the input's unit. */
struct dx_mesh_job {
    const struct dx_mesh_mode *mode;
    const char *path;
    const struct dx_cloud *cloud;
    const double *xyz; /* [n_input][3], as read: cloud->index[] are places in it */
    size_t n_input;
    double spacing, noise;   /* dx_cloud_spacing, dx_cloud_noise */
    const double *viewpoint; /* [3], where the points were seen from; NULL: not told */
    struct dx_pool *pool;
    struct dx_cloud_mesh *mesh;   /* takes what is made */
    struct dx_progress *progress; /* dx_progress_stage, dx_progress_share */
    json_t *stats;                /* an object; the mode's own numbers go there */
};

struct dx_mesh_mode {
    const char *name;
    const char *about;                    /* one line for the help, with its newline */
    const char *help;                     /* the lines of its options */
    const struct dx_mesh_option *options; /* ends with a name of NULL */
    size_t config_len;                    /* of its parameters */
    size_t point_len; /* bytes that run() takes for each point, at most but for odd inputs, beside
                         the cloud and the mesh */
    void (*defaults)(void *config);
    /* 0, having given triangles to job->mesh; none at all is no error. Errors: -EINVAL (parameters
     * that do not go together), -ENOMEM; what else the algorithm has. */
    int (*run)(const struct dx_mesh_job *job, void *config, struct dx_err *err);
};

extern const struct dx_mesh_mode dx_mesh_mode_project;
extern const struct dx_mesh_mode dx_mesh_mode_delaunay;
extern const struct dx_mesh_mode dx_mesh_mode_smooth;

/* The mode that a command line asks for; NULL: none of these. */
const struct dx_mesh_mode *dx_mesh_mode_asked(int argc, char **argv);

/* The names of all modes with `terrain` first, for dx_arg_choice(); ends with NULL. */
const char *const *dx_mesh_mode_names(void);

/* A line for people: "FILE: NAME: TEXT". */
__attribute__((format(printf, 2, 3))) void dx_mesh_job_tell(const struct dx_mesh_job *job,
                                                            const char *fmt, ...);

/* "stages": {NAME: SECONDS} in the statistics. */
void dx_mesh_job_stage(const struct dx_mesh_job *job, const char *name, double seconds);

#endif
