/* What a recording does now, in a word, from its members of a status. */
#ifndef DX_RECORDING_STATE_H
#define DX_RECORDING_STATE_H

#include <jansson.h>

static inline const char *dx_recording_state(const json_t *recording)
{
    const int writing = json_is_true(json_object_get(recording, "writing"));

    if (json_object_get(recording, "error_text"))
        return "failing";
    if (json_is_true(json_object_get(recording, "started")))
        return writing ? "recording" : "waiting"; /* for the first block of a frame */
    return writing ? "stopping" : "stopped";
}

#endif
