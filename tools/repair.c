/* A damaged recording to a whole one. */
#include "tools/repair.h"

#include "drivers/file/mcap_repair.h"
#include "tools/mcap_open.h"
#include "tools/out_file.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

static void tell(const char *command, const char *in, const struct dx_mcap_reader *r,
                 const struct dx_mcap_repaired *report)
{
    uint64_t n = dx_mcap_reader_damages(r);
    const struct dx_mcap_damage *d;

    for (uint64_t k = 0; (d = dx_mcap_reader_damage(r, k)); k++)
        fprintf(stderr, "%s: %s: byte %" PRIu64 ", %" PRIu64 " bytes: %s\n", command, in, d->offset,
                d->len, d->text);
    fprintf(stderr,
            "%s: %s: %" PRIu64 " damaged %s; saved %" PRIu64 " messages, %u attachments "
            "and metadata records\n",
            command, in, n, n == 1 ? "place" : "places", report->n_messages, report->n_items);
    if (report->n_lost || report->n_lost_items)
        fprintf(stderr, "%s: %s: lost %" PRIu64 " messages, %u attachments and metadata records\n",
                command, in, report->n_lost, report->n_lost_items);
}

int dx_repair_file(const char *in, const char *out, const char *command, struct dx_err *err)
{
    const struct dx_mcap_read_options options = {.scan = true};
    struct dx_mcap_repaired report;
    struct dx_mcap_sink sink;
    struct dx_mcap_file file;
    struct dx_out_file f;
    int rc = dx_mcap_file_open(&file, in, &options, err);

    if (rc)
        return rc;
    rc = dx_out_file_open(&f, out, err);
    if (rc == 0) {
        sink = dx_mcap_sink_fd(fileno(f.stream));
        rc = dx_mcap_repair(file.reader, &sink, &report, err);
        if (rc) {
            dx_err_prefix(err, out);
            dx_out_file_abort(&f);
        } else {
            rc = dx_out_file_commit(&f, err);
        }
    }
    if (rc == 0)
        tell(command, in, file.reader, &report);
    dx_mcap_file_close(&file);
    return rc;
}
