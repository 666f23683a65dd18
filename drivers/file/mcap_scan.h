/* A scan of an MCAP file under way: what its two files share. */
#ifndef DX_MCAP_SCAN_H
#define DX_MCAP_SCAN_H

#include "drivers/file/mcap_read_priv.h"

/* Positive: the record's own length is not to be trusted. */
#define DX_MCAP_E_RESYNC 1

struct dx_mcap_scan {
    struct dx_mcap_reader *r;
    uint64_t at, len; /* the record */
    uint8_t op;
    struct dx_mcap_part run; /* messages outside of chunks; at.len 0: none is open */
    uint64_t n_messages, start, end;
    bool ended; /* the data have their end */
};

/* Takes in the record at `at`. 0 (whatever is damaged is noted), DX_MCAP_E_RESYNC, -ENOMEM, -E2BIG.
 */
int dx_mcap_scan_record(struct dx_mcap_scan *s);
int dx_mcap_scan_close_run(struct dx_mcap_scan *s);

#endif
