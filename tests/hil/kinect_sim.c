/* A Kinect's camera as bytes. */
#include "tests/hil/kinect_sim.h"

#include "core/base/bytes.h"
#include "drivers/kinect/kinect_protocol.h"

void kinect_sim_init(struct kinect_sim *sim)
{
    memset(sim, 0, sizeof(*sim));
    sim->constants = (struct dx_kinect_constants){7.5f, 2.3f, 120.0f, 0.1042f, 200};
    sim->random = 1;
    sim->ticks_a_frame = 2000000;
    sim->ticks = 1000;
    sim->registers[DX_KINECT_DEPTH_FORMAT] = 3;
    memset(sim->packed, 0xff, sizeof(sim->packed));
}

int kinect_sim_bits(const struct kinect_sim *sim)
{
    return sim->registers[DX_KINECT_DEPTH_FORMAT] == 2 ? 10 : 11;
}

bool kinect_sim_streams(const struct kinect_sim *sim)
{
    return sim->registers[DX_KINECT_DEPTH_STREAM] == 2;
}

/* Bit by bit, unlike what it tests. */
void kinect_sim_pack(uint8_t *packed, const uint16_t *codes, size_t n, int bits)
{
    memset(packed, 0, (n * (size_t)bits + 7) / 8);
    for (size_t k = 0; k < n; k++)
        for (int b = 0; b < bits; b++) {
            size_t at = k * (size_t)bits + (size_t)b;

            if (codes[k] >> (bits - 1 - b) & 1)
                packed[at / 8] |= (uint8_t)(0x80 >> at % 8);
        }
}

void kinect_sim_codes(struct kinect_sim *sim, const uint16_t *codes)
{
    kinect_sim_pack(sim->packed, codes, DX_KINECT_PIXELS, kinect_sim_bits(sim));
}

void kinect_sim_depths(struct kinect_sim *sim, const uint16_t *mm)
{
    static uint16_t codes[DX_KINECT_PIXELS];
    uint16_t lut[DX_KINECT_N_CODES], none = (uint16_t)((1 << kinect_sim_bits(sim)) - 1);

    dx_kinect_lut_fill(lut, &sim->constants, kinect_sim_bits(sim), 1e5);
    for (uint32_t k = 0; k < DX_KINECT_PIXELS; k++) {
        uint32_t lo = 0, hi = 1;

        codes[k] = none;
        if (mm[k] == 0)
            continue;
        while (hi < none && lut[hi] < mm[k] && lut[hi] >= lut[lo])
            lo = hi++;
        if (hi < none && lut[hi] >= mm[k])
            codes[k] = (uint16_t)(lut[hi] - mm[k] < mm[k] - lut[lo] ? hi : lo);
    }
    kinect_sim_codes(sim, codes);
}

/* ---- packets --------------------------------------------------------------------------------- */

static uint32_t draw(struct kinect_sim *sim)
{
    sim->random = sim->random * UINT64_C(6364136223846793005) + 1442695040888963407u;
    return (uint32_t)(sim->random >> 33) % 1000000;
}

static bool lost(struct kinect_sim *sim)
{
    const struct kinect_sim_faults *f = &sim->faults;

    return draw(sim) < f->lose_ppm || sim->at - f->lose_at < f->lose_n;
}

static size_t put_packet(struct kinect_sim *sim, uint8_t *packet)
{
    const struct kinect_sim_faults *f = &sim->faults;
    size_t frame_len = dx_kinect_frame_len(kinect_sim_bits(sim));
    unsigned n = dx_kinect_n_packets(frame_len);
    size_t payload = dx_kinect_payload_len(frame_len, sim->at);

    memset(packet, 0, DX_KINECT_PACKET_HEADER_LEN);
    packet[0] = draw(sim) < f->magic_ppm ? 'X' : 'R';
    packet[1] = 'B';
    packet[3] = sim->at == 0 ? 0x71 : sim->at + 1 == n ? 0x75 : 0x72;
    if (draw(sim) < f->flag_ppm)
        packet[3] = (uint8_t)(0x71 + draw(sim) % 5);
    packet[5] = sim->sequence;
    dx_put_u32(packet + 8, sim->at == 0 ? 0 : sim->ticks);
    memcpy(packet + DX_KINECT_PACKET_HEADER_LEN,
           sim->packed + (size_t)sim->at * DX_KINECT_PAYLOAD_LEN, payload);
    if (draw(sim) < f->short_ppm)
        payload = draw(sim) % payload;
    return DX_KINECT_PACKET_HEADER_LEN + payload;
}

size_t kinect_sim_packet(struct kinect_sim *sim, uint8_t packet[DX_KINECT_PACKET_LEN])
{
    unsigned n = dx_kinect_n_packets(dx_kinect_frame_len(kinect_sim_bits(sim)));
    bool gone;
    size_t len;

    if (sim->faults.idle_every && draw(sim) % sim->faults.idle_every == 0)
        return 0;
    do {
        gone = lost(sim);
        len = put_packet(sim, packet);
        sim->sequence++;
        if (++sim->at == n) {
            sim->at = 0;
            sim->ticks += sim->ticks_a_frame;
            sim->n_frames++;
        }
    } while (gone);
    return len;
}

/* ---- control --------------------------------------------------------------------------------- */

static void reply(struct kinect_sim *sim, uint16_t command, uint16_t tag, size_t payload_len)
{
    sim->reply[0] = 'R';
    sim->reply[1] = 'B';
    dx_put_u16(sim->reply + 2, (uint16_t)(payload_len / 2));
    dx_put_u16(sim->reply + 4, command);
    dx_put_u16(sim->reply + 6, tag);
    sim->reply_len = DX_KINECT_MESSAGE_LEN + payload_len;
    sim->n_silent = sim->faults.n_silent;
    sim->n_stale = sim->faults.n_stale;
}

static void put_constants(struct kinect_sim *sim, uint8_t *p)
{
    dx_put_u32(p, dx_f32_bits(sim->constants.emitter_cm));
    dx_put_u32(p + 4, dx_f32_bits(sim->constants.rcmos_cm));
    dx_put_u32(p + 8, dx_f32_bits(sim->constants.reference_mm));
    dx_put_u32(p + 12, dx_f32_bits(sim->constants.pixel_mm));
}

int kinect_sim_out(struct kinect_sim *sim, const uint8_t *bytes, size_t len)
{
    uint8_t *payload = sim->reply + DX_KINECT_MESSAGE_LEN;
    uint16_t command, tag, reg;

    if (len < 10 || bytes[0] != 'G' || bytes[1] != 'M' || 8 + 2u * dx_get_u16(bytes + 2) != len)
        return -1;
    command = dx_get_u16(bytes + 4);
    tag = dx_get_u16(bytes + 6);
    memset(sim->reply, 0, sizeof(sim->reply));
    sim->n_requests++;
    if (command == DX_KINECT_WRITE && len == 12) {
        reg = dx_get_u16(bytes + 8);
        payload[0] = sim->faults.refuse || reg >= KINECT_SIM_N_REGISTERS;
        if (!payload[0]) {
            sim->registers[reg] = dx_get_u16(bytes + 10);
            sim->at = reg == DX_KINECT_DEPTH_STREAM ? 0 : sim->at;
        }
        reply(sim, command, tag, 2);
    } else if (command == DX_KINECT_FIXED && len == 18) {
        put_constants(sim, payload + 94);
        reply(sim, command, tag, sim->windows ? 334 : 322);
    } else if (command == DX_KINECT_ALGORITHM && len == 18) {
        dx_put_u16(payload + 2, sim->constants.shift);
        reply(sim, command, tag, 4);
    } else
        return -1;
    return (int)len;
}

int kinect_sim_in(struct kinect_sim *sim, uint8_t *bytes, size_t len)
{
    size_t n = sim->reply_len < len ? sim->reply_len : len;

    if (n == 0)
        return 0;
    if (sim->n_silent) {
        sim->n_silent--;
        return sim->n_silent % 2 ? 0 : (int)len; /* nothing, or as much as was asked for of it */
    }
    memcpy(bytes, sim->reply, n);
    if (sim->n_stale) {
        sim->n_stale--;
        bytes[6]--;
        return (int)n;
    }
    sim->reply_len = 0;
    return (int)n;
}
