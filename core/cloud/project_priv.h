/* Parts of the projection-based mesh: the reference point and what is near it. Owned by the one
 * thread that runs dx_project. Distances are in steps of the lattice. */
#ifndef DX_PROJECT_PRIV_H
#define DX_PROJECT_PRIV_H

#include "core/cloud/flat_order.h"
#include "core/cloud/project.h"
#include "core/cloud/point_ring.h"

#define DX_PROJECT_MAX_NEAR   1024 /* points in the sphere of influence */
#define DX_PROJECT_MAX_CAND   64   /* of them that are not completed: the nearest */
#define DX_PROJECT_MAX_LOCAL  384  /* with the ends of their boundary edges */
#define DX_PROJECT_MAX_CHAINS 512
#define DX_PROJECT_FLAT       (1 << 22) /* the radius, in units of the plane */

/* DX_WAITED: fringe, for the second time in the queue */
enum dx_project_state { DX_FREE, DX_FRINGE, DX_WAITED, DX_BOUNDARY, DX_COMPLETED };

struct dx_project_point {
    float normal[3]; /* sum: of planes of reference points around it, or of its triangles */
    float reach;     /* of who found it; 0: unknown */
    uint32_t ring;
    uint32_t local; /* its place in struct dx_local, if that names it */
};

/* A chain of a point's ring; places in struct dx_local. */
struct dx_local_chain {
    uint16_t first, last;
    bool single; /* one triangle: less than half a turn */
};

struct dx_local_edge {
    uint16_t a, b;
};

/* The vicinity of the reference point, which is the origin of the plane. */
struct dx_local {
    uint32_t n, n_cand; /* candidates come first, then other ends of their boundary edges */
    uint32_t id[DX_PROJECT_MAX_LOCAL];
    struct dx_flat at[DX_PROJECT_MAX_LOCAL];
    bool hidden[DX_PROJECT_MAX_LOCAL]; /* cannot be joined to the reference point */
    bool linked[DX_PROJECT_MAX_LOCAL]; /* is joined to it by a boundary edge */
    bool behind[DX_PROJECT_MAX_LOCAL]; /* its triangles: what happens there is out of sight */
    /* chains of candidate k: from chain[k] to chain[k + 1]; none for the others */
    uint32_t chain_start[DX_PROJECT_MAX_CAND + 1];
    uint32_t n_chains, n_own, n_edges;
    struct dx_local_chain chain[DX_PROJECT_MAX_CHAINS];
    struct dx_local_chain own[DX_RING_MAX]; /* of the reference point */
    struct dx_local_edge edge[2 * DX_PROJECT_MAX_CHAINS];
    uint32_t n_order;
    struct dx_angle order[DX_PROJECT_MAX_CAND]; /* by angle; number: place */
};

struct dx_project_run {
    const struct dx_cloud *cloud;
    const struct dx_project_config *config;
    const struct dx_project_sink *sink;
    struct dx_project_stats *stats;
    struct dx_project_point *point; /* [n] by rank, as what follows */
    uint8_t *state;
    struct dx_rings rings;
    uint32_t *queue; /* [n], in a circle: fringe points, once each */
    uint32_t head, n_queued;
    enum dx_project_plane plane; /* as configured, or for a last look */
    double cos_alpha, cos_beta;
    double spacing, max_edge; /* steps */

    /* the reference point */
    uint32_t r;
    double normal[3], u[3], v[3];
    double flat_u[3], flat_v[3]; /* from steps to units of the plane */
    double radius, widest;       /* of influence; as far as it may be widened */
    double reach;                /* the radius, not widened */
    double widen;                /* by what it was not enough */
    uint32_t n_near;
    struct dx_near near[DX_PROJECT_MAX_NEAR];  /* all states, without r */
    double offset[3][DX_PROJECT_MAX_NEAR + 1]; /* of each from r; a 0 after the last */
    struct dx_local local;
};

/* project_gather.c: near, radius and widest, for r; `factor` widens. */
void dx_project_gather(struct dx_project_run *run, double factor);

/* project_plane.c: normal, u and v; false: the points near r make none. */
bool dx_project_set_plane(struct dx_project_run *run);
struct dx_flat dx_project_flat(const struct dx_project_run *run, uint32_t rank);
/* The same of near[k]. */
struct dx_flat dx_project_flat_near(const struct dx_project_run *run, uint32_t k);

/* project_sight.c: local, and what is hidden; false: too much is near. */
bool dx_project_look(struct dx_project_run *run);
/* Whether triangle (r, a, b), of places, may be made. */
bool dx_project_may_join(const struct dx_project_run *run, uint32_t a, uint32_t b);
/* No boundary edge is in the way from r to the place. */
bool dx_project_sees(const struct dx_project_run *run, uint32_t place);

/* project_star.c: makes the triangles that r lacks. Errors as dx_project; DX_STAR_NARROW: points
 * beyond the radius might have been nearer. */
enum { DX_STAR_DONE = 0, DX_STAR_NARROW = 1 };
int dx_project_star(struct dx_project_run *run, bool may_widen);

/* project_add.c: makes triangle (a, b, c), of ranks, which fits in all three rings. Errors:
 * -ENOMEM, the sink's. */
int dx_project_add(struct dx_project_run *run, uint32_t a, uint32_t b, uint32_t c);
bool dx_project_fits(const struct dx_project_run *run, uint32_t a, uint32_t b, uint32_t c);

/* The queue. */
void dx_project_push(struct dx_project_run *run, uint32_t v);
uint32_t dx_project_pop(struct dx_project_run *run);

/* project_loops.c: closes small holes. */
int dx_project_close_loops(struct dx_project_run *run);

#endif
