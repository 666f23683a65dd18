/*
 * MCAP files from outside: by index and by scanning, in both orders, with all items; then repaired,
 * and the repaired file must be whole and hold as many messages as the repair says.
 */
#include "drivers/file/mcap_read.h"
#include "drivers/file/mcap_repair.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

#define MAX_CHUNK ((size_t)256 << 10)

struct memory {
    uint8_t *bytes;
    size_t len, cap;
};

static int memory_read(void *ctx, uint64_t offset, void *out, size_t len)
{
    const struct memory *m = ctx;

    if (offset > m->len || len > m->len - offset)
        abort(); /* a reader never asks for what the file does not have */
    memcpy(out, m->bytes + offset, len);
    return 0;
}

static int memory_write(void *ctx, uint64_t offset, const void *in, size_t len)
{
    struct memory *m = ctx;

    if (offset > m->len)
        abort();
    if (offset + len > m->cap) {
        m->cap = 2 * (offset + len);
        m->bytes = realloc(m->bytes, m->cap);
        if (!m->bytes)
            return -ENOMEM;
    }
    memcpy(m->bytes + offset, in, len);
    m->len = offset + len > m->len ? offset + len : m->len;
    return 0;
}

static struct dx_mcap_reader *open_memory(struct memory *m, bool scan)
{
    const struct dx_mcap_source source = {m, memory_read, m->len};
    const struct dx_mcap_read_options o = {.scan = scan, .max_chunk = MAX_CHUNK};
    struct dx_mcap_reader *r = NULL;
    struct dx_err err;

    return dx_mcap_reader_open(&r, &source, &o, &err) == 0 ? r : NULL;
}

/* Every message; each byte of it is there. The count. */
static uint64_t read_all(struct dx_mcap_reader *r, enum dx_mcap_order order)
{
    const struct dx_mcap_query q = {.order = order};
    struct dx_mcap_iter *it = NULL;
    struct dx_mcap_message m;
    uint64_t n = 0;
    volatile uint8_t sum = 0;

    if (dx_mcap_iter_new(&it, r, &q) < 0)
        return 0;
    while (dx_mcap_iter_next(it, &m) == 0) {
        for (size_t k = 0; k < m.data.len; k++)
            sum = (uint8_t)(sum + m.data.p[k]);
        if (!dx_mcap_reader_find(r, m.channel_id))
            abort();
        n++;
    }
    dx_mcap_iter_free(it);
    return n;
}

static void read_items(struct dx_mcap_reader *r)
{
    const struct dx_mcap_item_index *item;
    struct dx_mcap_attachment a;
    struct dx_mcap_metadata m;
    struct dx_mcap_pair pair;
    struct dx_err err;

    for (uint32_t k = 0; (item = dx_mcap_reader_attachment(r, k)); k++)
        dx_mcap_reader_read_attachment(r, item, &a, &err);
    for (uint32_t k = 0; (item = dx_mcap_reader_metadata(r, k)); k++)
        if (dx_mcap_reader_read_metadata(r, item, &m, &err) == 0) {
            struct dx_reader map = dx_reader_init(m.map.p, m.map.len);

            while (dx_mcap_next_pair(&pair, &map) == 0)
                ;
        }
}

static void check_repaired(struct memory *m, const struct dx_mcap_repaired *report)
{
    struct dx_mcap_reader *r = open_memory(m, true);
    uint64_t n;

    if (!r)
        abort();
    n = read_all(r, DX_MCAP_LOG_TIME);
    if (n != report->n_messages || dx_mcap_reader_damages(r) > 0)
        abort();
    dx_mcap_reader_free(r);
}

static void repair(struct dx_mcap_reader *r)
{
    struct memory out = {0};
    const struct dx_mcap_sink sink = {&out, memory_write, NULL};
    struct dx_mcap_repaired report;
    struct dx_err err;

    if (dx_mcap_repair(r, &sink, &report, &err) == 0)
        check_repaired(&out, &report);
    free(out.bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    struct memory m = {malloc(len ? len : 1), len, len};

    if (!m.bytes)
        return 0;
    memcpy(m.bytes, bytes, len);
    for (int scan = 0; scan < 2; scan++) {
        struct dx_mcap_reader *r = open_memory(&m, scan);

        if (!r)
            break;
        read_all(r, DX_MCAP_FILE_ORDER);
        read_all(r, DX_MCAP_LOG_TIME);
        read_items(r);
        if (scan)
            repair(r);
        dx_mcap_reader_free(r);
    }
    free(m.bytes);
    return 0;
}
