/*
 * A damaged or cut MCAP file to a whole one: what can be read is copied, in its order, with new
 * message indexes, summary and footer. Chunks that are good keep their bytes; of others the
 * messages that can be read are put into chunks of their own.
 */
#ifndef DX_MCAP_REPAIR_H
#define DX_MCAP_REPAIR_H

#include "drivers/file/mcap_read.h"

struct dx_mcap_repaired {
    uint64_t n_messages; /* of the new file */
    uint64_t n_moved;    /* of these, those out of damaged chunks and from outside of chunks */
    uint64_t n_lost;     /* messages that were read and fit into no chunk */
    uint32_t n_items, n_lost_items; /* attachments and metadata */
};

/* `r` was opened with `scan`, which has told what is damaged. Errors: the sink's, -ENOMEM, with err
 * set; the new file is then not whole. */
int dx_mcap_repair(struct dx_mcap_reader *r, const struct dx_mcap_sink *sink,
                   struct dx_mcap_repaired *out, struct dx_err *err);

#endif
