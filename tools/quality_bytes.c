/* What a dexel costs on the wire, beside the least that its noise allows. */
#include "tools/quality.h"

#include "core/base/trig.h"
#include "core/wire/chunk.h"

#include <errno.h>
#include <stdlib.h>

#define MM 1e-3

/* Encodings by column; a further one is an entry here and a case in encode(). */
enum { F32, Q16, DELTA, N_ENCODINGS };

struct encoder {
    struct dx_tile tile;
    uint8_t *body;
};

static size_t encode(struct encoder *e, const struct dx_quality_rig *rig, int encoding)
{
    if (encoding == Q16)
        return dx_chunk_put_q16(e->body, &e->tile);
    if (encoding == DELTA)
        return dx_chunk_put_delta(e->body, &e->tile);
    return dx_chunk_put_f32(e->body, &e->tile, &rig->tiling, rig->geometry);
}

/* Bytes of all chunks of the rig's mesh, without the messages around them. */
static int chunk_bytes(double n_bytes[N_ENCODINGS], const struct dx_quality_rig *rig)
{
    struct encoder *e = calloc(1, sizeof(*e));
    int rc = e ? 0 : -ENOMEM;

    if (e)
        e->body = malloc(dx_chunk_max_len(DX_ENCODING_F32));
    if (e && !e->body)
        rc = -ENOMEM;
    for (int k = 0; k < N_ENCODINGS; k++)
        n_bytes[k] = 0;
    for (uint32_t n = 0; rc == 0 && n < dx_tiling_n_tiles(&rig->tiling); n++)
        if (dx_terrain_tile(rig->terrain, n, &e->tile))
            for (int k = 0; k < N_ENCODINGS; k++)
                n_bytes[k] += (double)encode(e, rig, k);
    if (e)
        free(e->body);
    free(e);
    return rc;
}

/* Entropy of Gaussian noise in steps of a unit, in bytes: log2(sigma / u * sqrt(2 pi e)) bits. What
 * surface there is comes on top. */
static double entropy_bytes(double sigma_units)
{
    return dx_log(sigma_units * 4.1327313541224930) / dx_log(2) / 8;
}

static int bytes_row(struct dx_quality_table *t, struct dx_quality_rig *rig)
{
    struct dx_terrain_params p = dx_quality_rig_params(rig);
    double n = (double)dx_plane_n_dexels(&rig->frame), n_bytes[N_ENCODINGS];
    struct dx_quality_row *row = dx_quality_row(t, &rig->scene);
    int rc = dx_quality_rig_mesh(rig, &p);

    if (rc == 0)
        rc = chunk_bytes(n_bytes, rig);
    if (rc)
        return rc;
    row->value[0] = entropy_bytes(rig->scene.sigma[0] / (double)rig->geometry->unit_m) *
                    (1 - rig->scene.dropout);
    for (int k = 0; k < N_ENCODINGS; k++)
        row->value[1 + k] = n_bytes[k] / n;
    dx_quality_hold(row, 1 + Q16, DX_QUALITY_AT_MOST, 2.5);
    dx_quality_hold(row, 1 + DELTA, DX_QUALITY_AT_MOST, 1.2);
    return 0;
}

int dx_quality_theme_bytes(struct dx_quality_run *run)
{
    static const struct {
        double sigma, dropout;
    } cases[] = {{2 * MM, 0}, {10 * MM, 0}, {10 * MM, 0.05}};
    struct dx_quality_table t = {
        .theme = "bytes",
        .title = "Bytes a dexel",
        .text =
            "All chunks of a frame over its dexels, in units of 1 mm. The bound is the entropy\n"
            "of the noise alone in the dexels that are there: no code without loss is shorter\n"
            "in the mean.",
        .column = {{"bound", "entropy_bytes", 3},
                   {"f32", "f32_bytes", 3},
                   {"q16", "q16_bytes", 3},
                   {"delta", "delta_bytes", 3}},
    };
    const struct dx_quality_scan hall = {DX_SCENE_HALL, 1500, 1000, false};
    struct dx_quality_rig *rig = NULL;
    int rc = dx_quality_run_rig(&rig, run, &hall);

    for (size_t k = 0; rc == 0 && k < sizeof(cases) / sizeof(cases[0]); k++) {
        struct dx_quality_draw draw = {
            .sigma = {cases[k].sigma}, .dropout = cases[k].dropout, .seed = run->seed};

        dx_quality_rig_draw(rig, &draw);
        rc = bytes_row(&t, rig);
    }
    dx_quality_rig_free(rig);
    if (rc == 0)
        dx_quality_report_table(run->report, &t);
    return rc;
}
