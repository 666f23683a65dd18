/*
 * The file driver: recordings replayed through the same path as devices. A source is one file, or a
 * directory or glob of files, which then are a sequence of frames in name order; the format is told
 * by content, then by name. Formats are rooms of their own (in_*.c) behind struct dx_format.
 */
#ifndef DX_FILE_H
#define DX_FILE_H

#include "drivers/driver.h"
#include "core/grid/fit.h"
#include "core/grid/represent.h"

struct dx_file_config {
    const char *path;  /* file, directory or glob */
    const char *topic; /* of clouds in MCAP files of other programs; NULL, "": the only one */
    double rate;       /* 1 real time, N times; 0 = max */
    double fps;        /* frames a second where the files carry no time; 0 = 10 */
    bool loop;
    double start_s, end_s; /* of recordings: the stretch that is played; end_s 0: to the end */
    bool restamp;          /* of recordings: device stamps tell when they are played */
    int attr_bytes;        /* -1: as the data has it; 0 none; 1; 2 */
    struct dx_fit_options fit;
    struct dx_thin_options thin; /* an array of chosen size instead of the files' own grid */
    bool exact;                  /* planes carry the points themselves; not with a mean of them */
    bool any_order;              /* of clouds in MCAP: as the file has them, not by time */
};

extern const struct dx_driver dx_file_driver;

/* How the file's points lay in the geometry that the driver chose (for --stats and describe). */
const struct dx_fit_report *dx_file_fit_report(const struct dx_device *dev);

#endif
