/*
 * Blocks of a SCIP scanner to frame parts: each block's ranges, and the stage that turns them into
 * columns. A decoder needs nothing but its configuration and the blocks. One owner, one thread.
 */
#ifndef DX_SCIP_DECODER_H
#define DX_SCIP_DECODER_H

#include "drivers/hokuyo/hokuyo.h"
#include "drivers/hokuyo/scip_block.h"

struct dx_scip_decoder;

/* Errors: -EINVAL, -ENOMEM. Borrows nothing. */
int dx_scip_decoder_new(struct dx_scip_decoder **out, const struct dx_hokuyo_config *config,
                        struct dx_err *err);
void dx_scip_decoder_free(struct dx_scip_decoder *d);

/* What a stage must know of a block's scan. */
struct dx_line_shape dx_scip_decoder_shape(const struct dx_scip_block *block, uint8_t attr_bytes);

/* As dx_driver.decode and dx_driver.describe. */
int dx_scip_decoder_decode(struct dx_scip_decoder *d, const struct dx_block *block,
                           const struct dx_frame_sink *sink, struct dx_err *err);
void dx_scip_decoder_describe(const struct dx_scip_decoder *d, char *text, size_t len);

#endif
