/*
 * Line scanners that speak SCIP 2.x (Hokuyo URG, UTM, UST and kin) on a turning stage: by USB, a
 * serial line or the network. docs/drivers/hokuyo.md.
 */
#ifndef DX_HOKUYO_H
#define DX_HOKUYO_H

#include "drivers/driver.h"
#include "drivers/hokuyo/scip_scan.h"
#include "drivers/stage.h"

enum dx_hokuyo_echo {
    DX_HOKUYO_ECHO_ONE, /* the scanner's own choice: every model can */
    DX_HOKUYO_ECHO_FIRST,
    DX_HOKUYO_ECHO_LAST,
    DX_HOKUYO_ECHO_STRONGEST,
};

struct dx_hokuyo_config {
    char *tty;                    /* "/dev/ttyACM0"; "": not by a tty */
    char *tcp;                    /* "192.168.0.10", "scanner:10940"; "": not by the network */
    char *port;                   /* neither: the USB port, as "1-2.3"; "": any */
    char *serial;                 /* as VV tells it; "": any */
    uint32_t baud;                /* of a tty that is a serial line */
    int echo;                     /* enum dx_hokuyo_echo */
    uint8_t attr_bytes;           /* 2: intensity with each dexel; 0 */
    double first_step, last_step; /* -1: all */
    uint32_t cluster, skip;       /* steps to a value; scans left out after each */
    struct dx_stage_config stage;
};

extern const struct dx_driver dx_hokuyo_driver;

/* NULL, or what in it does not go together, and *key is the key at fault ("stage.angles"). */
const char *dx_hokuyo_check(const struct dx_hokuyo_config *config, const char **key);

#endif
