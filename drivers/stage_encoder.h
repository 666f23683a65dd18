/*
 * A turning stage's encoder on GPIO lines, as an angle source. The configuration is constant; what
 * it opens belongs to the reader thread and has a thread of its own.
 */
#ifndef DX_STAGE_ENCODER_H
#define DX_STAGE_ENCODER_H

#include "core/base/err.h"
#include "drivers/gpio_line.h"

struct dx_angle_source;
struct dx_gpio_bank;

struct dx_encoder_config {
    char *a, *b, *z; /* gpio_line.h; z may be "": no index */
    enum dx_gpio_bias bias;
    uint32_t debounce_us;
    uint32_t counts; /* of a turn of the encoder, four for each of its cycles */
    double gear;     /* turns of the encoder for one of the stage */
    double zero_deg; /* of the stage at the index; without one, where it stands when opened */
    bool reverse;    /* counts up are clockwise from above */
};

/* NULL: it can be opened; else what is wrong with it, and *key is the key at fault
 * ("stage.encoder.a"). */
const char *dx_encoder_check(const struct dx_encoder_config *config, const char **key);

/* -EINVAL (the check), -ENOENT, -EBUSY, -ENOMEM, or what the chip gives. The configuration is
 * copied but for its texts, which are needed no longer. */
int dx_encoder_open(struct dx_angle_source **out, const struct dx_encoder_config *config,
                    struct dx_err *err);
/* The same on lines from elsewhere, for tests. */
int dx_encoder_open_on(struct dx_angle_source **out, const struct dx_encoder_config *config,
                       const struct dx_gpio_bank *bank, struct dx_err *err);

struct dx_encoder_status {
    int64_t count; /* of the encoder, now */
    bool is_uncertain;
    uint64_t n_edges, n_doubts, n_index, n_mismatch;
    int64_t last_mismatch;
};

/* Of a source that dx_encoder_open() gave. Any thread. */
void dx_encoder_tell(struct dx_angle_source *source, struct dx_encoder_status *status);

#endif
