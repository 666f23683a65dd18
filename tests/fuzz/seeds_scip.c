/* Writes the seeds of fuzz_scip into a folder: seeds_scip FOLDER. */
#include "drivers/hokuyo/scip_block.h"
#include "drivers/hokuyo/scip_session.h"
#include "tests/hil/scip_device.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MS 1000000u

static void save(const char *folder, const char *name, uint8_t kind, const uint8_t *bytes,
                 size_t len)
{
    char path[512];
    FILE *f;

    snprintf(path, sizeof(path), "%s/%s", folder, name);
    f = fopen(path, "wb");
    if (!f)
        exit(1);
    fputc(kind, f);
    fwrite(bytes, 1, len, f);
    fclose(f);
}

/* What the simulated scanner sends until the third scan; and blocks of scans. */
static void talk(const char *folder, const struct scip_model *model, const char *name, bool echoes)
{
    static struct scip_sim sim;
    static uint8_t said[1u << 16];
    const struct dx_scip_want want = {
        .intensity = echoes, .echoes = echoes, .first_step = 380, .last_step = 420, .cluster = 1};
    struct dx_scip_session s;
    uint64_t now = 1000 * (uint64_t)MS;
    size_t n_said = 0;
    char file[64];

    scip_sim_init(&sim, model, now);
    if (dx_scip_session_init(&s, &want, DX_SCIP_BLOCK_HEADROOM, now))
        exit(1);
    while (s.counts.n_scans < 3) {
        scip_sim_feed(&sim, s.out, s.out_len, now);
        dx_scip_session_sent(&s, s.out_len, now);
        now += MS;
        scip_sim_tick(&sim, now);
        if (n_said + sim.out_len < sizeof(said)) {
            memcpy(said + n_said, sim.out, sim.out_len);
            n_said += sim.out_len;
        }
        for (size_t at = 0; at < sim.out_len;)
            at += dx_scip_session_feed(&s, sim.out + at, sim.out_len - at, now);
        sim.out_len = 0;
        dx_scip_session_tick(&s, now);
    }
    snprintf(file, sizeof(file), "talk-%s", name);
    save(folder, file, 1, said, n_said);

    struct dx_scip_block b = {
        .status = s.scan.head.status,
        .params = s.params,
        .first = s.request.first,
        .last = s.request.last,
        .cluster = 1,
        .command = {(uint8_t)s.request.command[0], (uint8_t)s.request.command[1]},
        .device_ns = s.scan.device_ns,
        .host_ns = s.scan.host_ns};
    const struct dx_angle_sample angles[2] = {{s.scan.host_ns, 0.1, false},
                                              {s.scan.host_ns + 20 * MS, 0.12, false}};
    size_t len;
    const uint8_t *block = dx_scip_block_put(s.lines.reply, s.scan.len, &b, angles, 2, &len);

    snprintf(file, sizeof(file), "block-%s", name);
    save(folder, file, 0, block, len);
    dx_scip_session_fini(&s);
}

int main(int argc, char **argv)
{
    if (argc != 2)
        return 2;
    talk(argv[1], &scip_models[0], "urg", false);
    talk(argv[1], &scip_models[2], "utm", false);
    talk(argv[1], &scip_models[3], "echoes", true);
    return 0;
}
