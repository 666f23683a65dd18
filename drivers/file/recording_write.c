/* Channel, attachments, messages and gaps of a recording. */
#include "drivers/file/recording_write.h"

#include "drivers/file/mcap_record.h"

#include <errno.h>
#include <stdio.h>

int dx_recording_declare(struct dx_mcap_writer *w, const char *driver, const char *stream)
{
    const struct dx_mcap_pair pairs[] = {
        {dx_mcap_text("driver"), dx_mcap_text(driver)},
        {dx_mcap_text("stream"), dx_mcap_text(stream)},
    };
    uint8_t map[512];
    struct dx_writer out = dx_writer_init(map, sizeof(map));
    struct dx_mcap_channel channel = {
        .id = DX_RECORDING_CHANNEL,
        .topic = dx_mcap_text(DX_RECORDING_TOPIC),
        .message_encoding = dx_mcap_text(DX_RECORDING_ENCODING),
    };

    dx_mcap_put_pairs(&out, pairs, 2);
    channel.metadata = (struct dx_mcap_bytes){map, (size_t)(out.p - map)};
    return out.failed ? -E2BIG : dx_mcap_writer_channel(w, &channel);
}

static int attach(struct dx_mcap_writer *w, const char *name, const char *type, uint64_t time,
                  const void *bytes, size_t len)
{
    const struct dx_mcap_attachment a = {.log_time = time,
                                         .create_time = time,
                                         .name = dx_mcap_text(name),
                                         .media_type = dx_mcap_text(type),
                                         .data = {bytes, len}};

    return dx_mcap_writer_attachment(w, &a);
}

int dx_recording_attach_config(struct dx_mcap_writer *w, uint64_t time, const char *yaml,
                               size_t len)
{
    return attach(w, DX_RECORDING_CONFIG, DX_RECORDING_CONFIG_TYPE, time, yaml, len);
}

int dx_recording_attach_geometry(struct dx_mcap_writer *w, uint64_t time, const uint8_t *bytes,
                                 size_t len)
{
    return attach(w, DX_RECORDING_GEOMETRY, DX_RECORDING_GEOMETRY_TYPE, time, bytes, len);
}

int dx_recording_put_message(struct dx_mcap_writer *w, uint32_t sequence, uint64_t time,
                             const uint8_t *bytes, size_t len)
{
    const struct dx_mcap_message m = {.channel_id = DX_RECORDING_CHANNEL,
                                      .sequence = sequence,
                                      .log_time = time,
                                      .publish_time = time,
                                      .data = {bytes, len}};

    return dx_mcap_writer_message(w, &m);
}

/* A number as a text of the metadata. */
static struct dx_mcap_text number(char text[24], uint64_t v)
{
    snprintf(text, 24, "%llu", (unsigned long long)v);
    return dx_mcap_text(text);
}

int dx_recording_put_gap(struct dx_mcap_writer *w, const struct dx_recording_gap *gap)
{
    char n[24], first[24], from[24], to[24];
    const struct dx_mcap_pair pairs[] = {
        {dx_mcap_text("blocks"), number(n, gap->n)},
        {dx_mcap_text("first_block"), number(first, gap->first)},
        {dx_mcap_text("start_ns"), number(from, gap->start)},
        {dx_mcap_text("end_ns"), number(to, gap->end)},
    };
    uint8_t map[512];
    struct dx_writer out = dx_writer_init(map, sizeof(map));
    struct dx_mcap_metadata m = {.name = dx_mcap_text(DX_RECORDING_GAP)};

    dx_mcap_put_pairs(&out, pairs, 4);
    m.map = (struct dx_mcap_bytes){map, (size_t)(out.p - map)};
    return dx_mcap_writer_metadata(w, &m);
}
