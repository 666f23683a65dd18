/* Parts of the localized Delaunay mesh. Distances are in steps of the lattice. */
#ifndef DX_DELAUNAY_PRIV_H
#define DX_DELAUNAY_PRIV_H

#include "core/cloud/delaunay.h"
#include "core/cloud/angle_order.h"
#include "core/cloud/point_ring.h"

#include <math.h>

#define DX_STAR_MAX_NEAR 256       /* candidates */
#define DX_STAR_MAX      128       /* neighbours in a star */
#define DX_STAR_FLAT     (1 << 20) /* the radius of the nearest, in units of the plane */
#define DX_STAR_BLOCK    1024      /* points of a task, whose stars are in one block */
#define DX_STAR_N_ANGLES 257
#define DX_RING_WHOLE    UINT32_MAX /* in place of a ring: closed, takes no triangle any more */

/* The tangent plane of a point: u, v and n are right-handed. */
struct dx_tangent {
    uint32_t rank;
    const int32_t *at;
    double n[3], u[3], v[3];
    double scale; /* steps to units of the plane */
    bool shadow;
};

/* One point and its candidates; scratch of a thread. */
struct dx_star_site {
    struct dx_tangent plane;
    double nearest; /* distance */
    double reach;   /* within it all points are candidates */
    double height;  /* over the plane, at most */
    double paper_radius;
    uint32_t n;
    uint32_t rank[DX_STAR_MAX_NEAR]; /* by angle, as what follows */
    struct dx_flat at[DX_STAR_MAX_NEAR];
    /* as they were found */
    uint32_t n_found;
    uint32_t found[DX_STAR_MAX_NEAR];
    struct dx_flat found_at[DX_STAR_MAX_NEAR];
    double found_height[DX_STAR_MAX_NEAR];
    uint8_t order[DX_STAR_MAX_NEAR];
    struct dx_near near[DX_STAR_MAX_NEAR];
};

/* The local Delaunay neighbours of a point by angle, and the circles between them. */
struct dx_star {
    uint32_t n;
    uint32_t rank[DX_STAR_MAX];
    struct dx_flat at[DX_STAR_MAX];
    double circle[DX_STAR_MAX]; /* diameter, units of the plane, through [k] and the next; INFINITY:
                                   half a turn or more lies between them */
};

/* Each point's star in few bytes. A word is the rank of a neighbour, with DX_STAR_GAP where there
 * is no triangle between it and the next; beside it is how many corners find that triangle. */
#define DX_STAR_GAP        (1u << 31)
#define DX_STAR_RANK(word) ((word) & ~DX_STAR_GAP)

struct dx_stars {
    uint32_t n_blocks;
    uint32_t **word; /* blocks, of DX_STAR_BLOCK points */
    uint8_t **vote;
    uint32_t *start; /* [n] in its block */
    uint8_t *count;  /* [n] */
};

static inline const uint32_t *dx_star_words(const struct dx_stars *s, uint32_t rank)
{
    return s->word[rank / DX_STAR_BLOCK] + s->start[rank];
}

static inline const uint8_t *dx_star_votes(const struct dx_stars *s, uint32_t rank)
{
    return s->vote[rank / DX_STAR_BLOCK] + s->start[rank];
}

struct dx_delaunay_run {
    const struct dx_cloud *cloud;
    const struct dx_neighbours *nb;
    const float (*normals)[3];
    const struct dx_delaunay_config *config;
    const struct dx_delaunay_sink *sink;
    struct dx_delaunay_stats *stats;
    struct dx_pool *pool;
    uint32_t k;                             /* of the neighbours, that are candidates at first */
    double max_edge;                        /* steps; INFINITY: no bound */
    double quarter_turns[DX_STAR_N_ANGLES]; /* of sin^2 from 0 to 1 */
    struct dx_stars stars;
    /* of what is accepted: by rank, DX_RING_WHOLE or a ring */
    uint32_t *ring;
    struct dx_rings rings;
};

/* delaunay_plane.c: false: the point has no normal. */
bool dx_tangent_of(struct dx_tangent *t, const struct dx_delaunay_run *run, uint32_t rank);

/* To the nearest, halves away from 0. */
static inline int32_t dx_round_flat(double x)
{
    const double most = DX_FLAT_MAX / 2.0;

    x = x < 0 ? x - 0.5 : x + 0.5;
    x = x > most ? most : x;
    return (int32_t)(x < -most ? -most : x);
}

/* A point turned about the reference point into its plane, at its distance (section 5.4), and its
 * height over it; false: it is on the normal. */
static inline bool dx_tangent_put(struct dx_flat *out, double *height, const struct dx_tangent *t,
                                  const int32_t at[3])
{
    const double d[3] = {at[0] - t->at[0], at[1] - t->at[1], at[2] - t->at[2]};
    const double x = d[0] * t->u[0] + d[1] * t->u[1] + d[2] * t->u[2];
    const double y = d[0] * t->v[0] + d[1] * t->v[1] + d[2] * t->v[2];
    const double h = d[0] * t->n[0] + d[1] * t->n[1] + d[2] * t->n[2], tt = x * x + y * y;
    double turn = t->scale;

    if (!(tt > 0))
        return false;
    if (!t->shadow)
        turn *= sqrt(1 + h * h / tt);
    *height = fabs(h);
    *out = (struct dx_flat){dx_round_flat(x * turn), dx_round_flat(y * turn)};
    return out->x != 0 || out->y != 0;
}

static inline bool dx_tangent_flat(struct dx_flat *out, const struct dx_tangent *t,
                                   const int32_t at[3])
{
    double height;

    return dx_tangent_put(out, &height, t, at);
}

/* delaunay_candidates.c: of a point, by angle: its nearest neighbours, pruned by height. False: it
 * has no normal. */
bool dx_star_gather(struct dx_star_site *site, const struct dx_delaunay_run *run, uint32_t rank);
/* All within a wider radius, or one that is less where there are too many. */
void dx_star_widen(struct dx_star_site *site, const struct dx_delaunay_run *run, double radius);

/* delaunay_curvature.c: Taubin's tensor (section 5.2) from the candidates; magnitudes. */
void dx_star_curvature(double *least, double *most, const struct dx_star_site *site,
                       const struct dx_delaunay_run *run);
void dx_star_angles(double quarter_turns[DX_STAR_N_ANGLES]);

/* delaunay_star.c: the local Delaunay neighbours of a point, `origin`, among points by angle; ranks
 * decide what circles do not. */
void dx_star_scan(struct dx_star *star, const struct dx_flat *at, const uint32_t *rank, uint32_t n,
                  uint32_t origin);

/* delaunay_stars.c */
int dx_stars_make(struct dx_delaunay_run *run);
void dx_stars_fini(struct dx_stars *stars);
/* The star of one point, with no more circles than are surface; its words' number. */
uint32_t dx_star_make(uint32_t *words, struct dx_star_site *site, struct dx_star *star,
                      const struct dx_delaunay_run *run, uint32_t rank, bool *widened);

/* delaunay_accept.c: by votes. */
int dx_delaunay_accept(struct dx_delaunay_run *run);

/* delaunay_rings.c: whether triangle (a, b, c) fits in the rings of its corners; lies beside what
 * is there in their planes; it goes into all three rings and to the caller. */
bool dx_delaunay_fits(const struct dx_delaunay_run *run, uint32_t a, uint32_t b, uint32_t c);
bool dx_delaunay_is_clear(const struct dx_delaunay_run *run, uint32_t a, uint32_t b, uint32_t c);
int dx_delaunay_add(struct dx_delaunay_run *run, uint32_t a, uint32_t b, uint32_t c);
/* Its parts: into the ring of one corner, and to the caller. */
int dx_delaunay_put(struct dx_delaunay_run *run, uint32_t v, uint32_t a, uint32_t b);
int dx_delaunay_give(struct dx_delaunay_run *run, uint32_t a, uint32_t b, uint32_t c);

/* delaunay_loops.c: the rim, of at most config->max_loop points, that begins with edge a-b and has
 * its hole to the left; how many. 0: longer, or not of a as its lowest. */
uint32_t dx_delaunay_trace(uint32_t *rim, const struct dx_delaunay_run *run, uint32_t a,
                           uint32_t b);

/* delaunay_holes.c */
int dx_delaunay_fill(struct dx_delaunay_run *run);

#endif
