/*
 * Terrain mode (Gopi and Krishnan 2002, section 5, as decided in docs/terrain.md): a fixed array of
 * published dexels and its mesh, tile by tile. The mesh is a pure function of the published array
 * and the parameters; every decision is made in integers. Owned by one mesher; tiles are computed
 * by a pool.
 */
#ifndef DX_TERRAIN_H
#define DX_TERRAIN_H

#include "core/base/pool.h"
#include "core/grid/plane.h"
#include "core/grid/tile.h"
#include "core/rows/rows.h"

enum dx_diag {
    DX_DIAG_FIXED = 0, /* always a-c, unless b-d gives more triangles */
    DX_DIAG_SHORT = 1, /* the diagonal whose ends differ less in range; ties a-c */
    DX_DIAG_BEND =
        2, /* the diagonal along which the surface bends less; b-d by a margin of noise */
};

/* Which samples are taken for a mix of two surfaces, and left out of the mesh. */
enum dx_mixed {
    DX_MIXED_OFF = 0,
    DX_MIXED_AXIS = 1,   /* cut off from both neighbours of its row, or of its column */
    DX_MIXED_STRICT = 2, /* besides, joined to at most three of its eight neighbours */
};

/* What becomes of a dexel's samples over the frames: estimator.h. */
enum dx_filter {
    DX_FILTER_OFF = 0,     /* the newest sample */
    DX_FILTER_MEAN = 1,    /* mean of up to n_max that agree; stray ones left out, gaps bridged */
    DX_FILTER_MEDIAN3 = 2, /* median of the last three */
};

struct dx_ingest_params {
    enum dx_filter filter;
    uint32_t n_max; /* frames that a mean counts at most, 1..255; default 16 */
    uint32_t n_gap; /* frames without a return that a mean bridges, 0..254; default 2 */
    /* An estimate that departs by so many sigmas from what is published makes its tile published
     * anew; 0: any difference. Below 0: DX_HOLD_SIGMAS with a filter, 0 without; the default. */
    double hold;
    uint32_t keyframe; /* every so many frames everything is published; 0: never */
};

#define DX_HOLD_SIGMAS 1.5

struct dx_terrain_params {
    struct dx_ingest_params ingest;
    double sigma[3];  /* s0 (m), s1 (1), s2 (1/m): sigma(r) = s0 + s1 r + s2 r^2, 1 sigma */
    bool sigma_given; /* false: estimated from the first frame, then kept */
    bool smooth;      /* ranges are smoothed along the beam before they are published: smooth.h */
    double
        tilt_deg;   /* steepest incidence joined by the first-order rule; default 78.69 (tan = 5) */
    double noise_k; /* noise gate in sigmas; default 4 */
    double cap_m;   /* longest edge, metres; 0 = no cap */
    bool rescue;    /* second-order rule: keep steep planes that the first-order rule cuts */
    enum dx_mixed mixed;
    uint8_t bridge; /* missing dexels in a row that a strut may span: 0, 1, 2 */
    bool caps;      /* close the hole at each pole of a full turn by a fan */
    bool normals;   /* compute a normal for each vertex */
    bool paper; /* the paper's own rule: length <= cap_m, nothing else; overrides the other rules */
    enum dx_diag diag;
    enum dx_simd simd; /* instruction set of the inner loops: the same mesh by every one */
};

/* The defaults named above; sigma not given; rescue, mixed axis, bridge 1, diag bend; not smoothed,
 * no caps, no normals. */
void dx_terrain_params_default(struct dx_terrain_params *p);

/* NULL, or what is wrong with the parameters ("tilt must be in 0..89"). */
const char *dx_terrain_params_check(const struct dx_terrain_params *p);

/* NULL, or why an exact stream cannot have the parameters: what is published must be a sample. */
const char *dx_terrain_params_check_exact(const struct dx_terrain_params *p);

struct dx_terrain;

/*
 * Takes a reference on `g`. Everything is allocated here; the calls below allocate nothing.
 * `attr_bytes` 0, 1, 2. Errors: -EINVAL (what the checks above refuse, a grid too small), -ENOMEM.
 */
int dx_terrain_new(struct dx_terrain **out, struct dx_geometry *g,
                   const struct dx_terrain_params *params, uint8_t attr_bytes);
void dx_terrain_free(struct dx_terrain *t);

const struct dx_tiling *dx_terrain_tiling(const struct dx_terrain *t);
const struct dx_geometry *dx_terrain_geometry(const struct dx_terrain *t);
/* Where ranges are smoothed: as of the last commit. */
const struct dx_plane *dx_terrain_published(const struct dx_terrain *t);

/* The parameters in force: sigma is the estimate, and sigma_given is set, once it is settled. */
const struct dx_terrain_params *dx_terrain_params(const struct dx_terrain *t);

/*
 * Takes columns [col0, col0 + n_cols) of `frame` (of the array's size, and with points where the
 * geometry is exact; n_cols = width for a whole frame; each column once a frame), publishes what
 * params.ingest lets through, and marks the tiles that it touches. After each call, for each dexel
 * of those columns: it is published iff it has an estimate, and within max(hold * sigma, half a
 * unit) of it (where ranges are smoothed: what they are smoothed from is). Where the noise was not
 * given, the first whole frame that can tell it settles it (dx_terrain_params); until then it is
 * the floor for the mesh, samples are not averaged, and every difference is published. On the pool
 * (NULL: on the caller), whose calls end before this one.
 */
void dx_terrain_publish(struct dx_terrain *t, const struct dx_plane *frame, uint32_t col0,
                        uint32_t n_cols, struct dx_pool *pool);

/* The stream was interrupted: samples from before say nothing about those to come. What is
 * published stays until they do. */
void dx_terrain_forget(struct dx_terrain *t);

/*
 * Smooths what has changed (params.smooth), computes the marked tiles anew, on the pool (NULL: on
 * the caller), and returns how many changed; their bits are then set in dx_terrain_changed() until
 * the next commit. Tile n is (n / cols, n % cols).
 */
uint32_t dx_terrain_commit(struct dx_terrain *t, struct dx_pool *pool);
const uint64_t *dx_terrain_changed(const struct dx_terrain *t);

/* Which polar holes are closed by a fan over all dexels of their row, from column 0, when the caps
 * were asked for: bit 0 the first row, bit 1 the last. A row is closed when each of its edges has a
 * triangle. The fans belong to no tile. */
#define DX_CAP_FIRST 0x1u
#define DX_CAP_LAST  0x2u
uint32_t dx_terrain_caps(const struct dx_terrain *t);

/* Fills `tile` with what the mesh of the published array is there (as of the last commit). Any
 * thread, while no publish or commit runs. False: no triangle there (row, col and sizes are filled
 * all the same). */
bool dx_terrain_tile(const struct dx_terrain *t, uint32_t tile_number, struct dx_tile *tile);

/* Noise model from one frame: per octave of range, the median of what four samples of a row leave
 * when a plane is taken away; s0 and s2 fitted, s1 = 0, never below half a unit. False: the frame
 * has too few returns to tell, and sigma is that floor. */
bool dx_noise_estimate(double sigma[3], const struct dx_plane *frame, const struct dx_geometry *g);

#endif
