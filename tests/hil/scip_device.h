/*
 * A simulated SCIP 2 scanner (DEVICES.md 11.1): commands in, replies and scans out, faults on
 * demand. It knows no device and no clock of its own: times are given, so a test of hours takes
 * milliseconds. It stands in a box-shaped room, on a stage that turns evenly, so what it sees is
 * known. For scip_sim.c, redir_scip.c and unit tests; one thread.
 */
#ifndef SCIP_DEVICE_H
#define SCIP_DEVICE_H

#include "tests/hil/scip_models.h"
#include "tests/hil/scip_room.h"
#include "tests/hil/scip_track.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SCIP_SIM_OUT    (256u << 10)
#define SCIP_SIM_SERIAL "H0614967"

enum scip_sim_state { SIM_BOOTING, SIM_IDLE, SIM_SINGLE, SIM_MULTI, SIM_TIME, SIM_ERROR };

struct scip_sim {
    struct scip_model model;
    struct scip_faults faults;
    struct scip_pose pose;
    const struct scip_track *track; /* where its stage is; NULL: by the pose's speed */
    double room[6];                 /* low x, y, z, high x, y, z; metres */
    double skew;                    /* device clock: host * (1 + skew) + offset */
    int64_t offset_ms;
    uint64_t boot_ns, transfer_ns;
    const char *serial; /* as VV tells it; NULL: it tells none */

    enum scip_sim_state state;
    bool is_11, laser;
    uint64_t epoch_ns; /* host time when the device's clock was 0 */
    uint64_t until_ns; /* BOOTING */
    uint64_t rb_ns;
    uint64_t n_commands, n_scans, n_bytes, n_blocks;
    char line[128];
    size_t line_len;

    /* MULTI */
    char command[16];
    uint32_t first, last, cluster, skip, left;
    bool endless;
    uint64_t next_ns; /* step 0 of the next scan */
    bool suspended;

    bool gone; /* the link has dropped */
    uint8_t out[SCIP_SIM_OUT];
    size_t out_len;
};

/* Well, idle, and without a stage that turns. */
void scip_sim_init(struct scip_sim *s, const struct scip_model *model, uint64_t now_ns);
/* Someone opens the link. */
void scip_sim_open(struct scip_sim *s, uint64_t now_ns);
/* Bytes that came by it. What it says is in out[0, out_len), for the caller to take. */
void scip_sim_feed(struct scip_sim *s, const uint8_t *bytes, size_t len, uint64_t now_ns);
/* The first `n` bytes of that have gone out. */
void scip_sim_sent(struct scip_sim *s, size_t n);
/* When it does something by itself; UINT64_MAX: never. */
uint64_t scip_sim_next_ns(const struct scip_sim *s);
void scip_sim_tick(struct scip_sim *s, uint64_t now_ns);

/* Of a turn of its mirror. */
double scip_sim_period_ns(const struct scip_sim *s);
/* Metres along the beam at the scanner's angle, when the stage is at psi. */
double scip_sim_range(const struct scip_sim *s, double angle, double psi);

#endif
