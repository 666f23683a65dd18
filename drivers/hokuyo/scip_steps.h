/*
 * Inside the session: what each state sends, how long it waits, and the request for the stream.
 * Owned by the session.
 */
#ifndef DX_SCIP_STEPS_H
#define DX_SCIP_STEPS_H

#include "drivers/hokuyo/scip_session.h"

#define DX_SCIP_S            1000000000ull
#define DX_SCIP_SILENCE      (150 * DX_SCIP_S / 1000)
#define DX_SCIP_NOISE        (500 * DX_SCIP_S / 1000) /* QT again, when it does not end by then */
#define DX_SCIP_TRIES        3                        /* of a command */
#define DX_SCIP_N_TIMES      16                       /* exchanges of TM1 */
#define DX_SCIP_NO_STAMP     UINT32_MAX
#define DX_SCIP_STATUS(a, b) (uint16_t)((a) << 8 | (b))

/* Goes to a state, and sends what belongs to it. */
void dx_scip_enter(struct dx_scip_session *s, enum dx_scip_state state, uint64_t now_ns);
/* Sends it (again) and waits for its answer. */
void dx_scip_send(struct dx_scip_session *s, uint64_t now_ns);
void dx_scip_queue(struct dx_scip_session *s, const char *command);

/* Whether a line is the echo of what this state has sent. */
bool dx_scip_is_echo(const struct dx_scip_session *s, const uint8_t *line, size_t len);

/* From what is wanted and what the scanner can; false with a trouble when it cannot. */
bool dx_scip_make_request(struct dx_scip_session *s);

/* Four periods of the scans that are asked for. */
uint64_t dx_scip_quiet_ns(const struct dx_scip_session *s);

/* The time line of TM1 or a scan; DX_SCIP_NO_STAMP when it is damaged. */
uint32_t dx_scip_stamp(const uint8_t *line, size_t len);

#endif
