/*
 * The replay of recordings, as a driver: read() takes the blocks of a recording at their pace,
 * decode() is that of the driver that recorded them. Frames keep their numbers until a jump (seek,
 * loop); from then on they are counted on, for a stream's frames never go back. Host stamps are
 * new, device stamps are those of the recording.
 *
 * The reader thread owns it; the functions below the driver are for the loop thread.
 */
#ifndef DX_PLAYER_H
#define DX_PLAYER_H

#include "drivers/driver.h"

#include <stddef.h>

/* Its configuration is a struct dx_file_config, of which path, rate and loop count. */
extern const struct dx_driver dx_player_driver;

/* ---- for the recorder of a replay, once it is open --------------------------------------------
 */

const char *dx_player_config_text(const struct dx_device *dev, size_t *len);
const char *dx_player_driver_name(const struct dx_device *dev);

/* ---- any thread ------------------------------------------------------------------------------
 */

void dx_player_pause(struct dx_device *dev, bool paused);
/* So many frames more, then paused. */
void dx_player_step(struct dx_device *dev, uint64_t n_frames);
/* Seconds from the start of the recording; at the end or behind it: the end. */
void dx_player_seek(struct dx_device *dev, double seconds);
/* 1 real time, N times, 0 as fast as possible. */
void dx_player_rate(struct dx_device *dev, double rate);

struct dx_player_status {
    bool paused, ended;
    double rate;
    double position_s, length_s; /* of the block handed over last, of all */
    uint64_t n_frames;           /* delivered, over all loops */
};

void dx_player_status(struct dx_device *dev, struct dx_player_status *out);

#endif
