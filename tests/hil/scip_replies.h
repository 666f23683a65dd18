/* Inside the simulated scanner: what it says, byte by byte. Owned by scip_device.c. */
#ifndef SCIP_REPLIES_H
#define SCIP_REPLIES_H

#include "tests/hil/scip_device.h"

/* Bytes as they are: no fault of scans touches them. */
void scip_sim_bytes(struct scip_sim *s, const void *bytes, size_t len);
/* Echo and status, each with its line's end. */
void scip_sim_reply(struct scip_sim *s, const char *echo, const char *status);
/* "KEY:value" of VV, PP and II, with its check character. */
void scip_sim_key(struct scip_sim *s, const char *text);
/* The device's clock, 24 bits of milliseconds, as four characters. */
void scip_sim_put_stamp(const struct scip_sim *s, uint8_t out[4], uint64_t host_ns);

/* The scan whose step 0 was at host_ns, with the echo and status of the request that it answers. */
void scip_sim_scan(struct scip_sim *s, const char *status, uint64_t host_ns);
/* The stream ends, or pauses, with a status instead of a scan. */
void scip_sim_event(struct scip_sim *s, const char *status);

#endif
