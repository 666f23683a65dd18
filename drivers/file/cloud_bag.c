/* Clouds out of MCAP. */
#include "drivers/file/cloud_bag.h"

#include "drivers/file/open_regular.h"
#include "drivers/file/recording.h"
#include "drivers/file/ros_cloud.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct dx_cloud_bag {
    char *path;
    int fd;
    struct dx_mcap_reader *reader;
    struct dx_mcap_iter *iter;
};

bool dx_cloud_bag_probe(const char *path)
{
    uint8_t magic[DX_MCAP_MAGIC_LEN];
    int fd = dx_open_regular(path, NULL);
    ssize_t n = fd >= 0 ? read(fd, magic, sizeof(magic)) : -1;

    if (fd >= 0)
        close(fd);
    return n == (ssize_t)sizeof(magic) && dx_mcap_probe(magic, sizeof(magic));
}

static bool is_cloud(const struct dx_mcap_reader *reader, const struct dx_mcap_channel *c)
{
    const struct dx_mcap_schema *s = dx_mcap_reader_find_schema(reader, c->schema_id);

    return s && dx_mcap_text_is(s->name, DX_ROS_CLOUD_NAME) &&
           dx_mcap_text_is(c->message_encoding, "cdr");
}

bool dx_cloud_bag_has_clouds(const struct dx_mcap_reader *reader)
{
    const struct dx_mcap_channel *c;

    for (uint32_t k = 0; (c = dx_mcap_reader_channel(reader, k)) != NULL; k++)
        if (is_cloud(reader, c))
            return true;
    return false;
}

/* The channel of clouds that is meant; NULL: none, or not one alone. `found` gets the topics that
 * there are. */
static const struct dx_mcap_channel *choose(const struct dx_mcap_reader *reader, const char *topic,
                                            char *found, size_t room)
{
    const struct dx_mcap_channel *c, *chosen = NULL;
    unsigned n = 0;
    size_t len = 0;

    for (uint32_t k = 0; (c = dx_mcap_reader_channel(reader, k)) != NULL; k++) {
        char text[128];

        if (!is_cloud(reader, c))
            continue;
        dx_mcap_text_copy(text, sizeof(text), c->topic);
        len += (size_t)snprintf(found + len, room - len, "%s%s", n ? ", " : "", text);
        len = len < room ? len : room - 1;
        n++;
        if (!topic || !*topic || dx_mcap_text_is(c->topic, topic))
            chosen = c;
    }
    return topic && *topic ? chosen : n == 1 ? chosen : NULL;
}

static int start(struct dx_cloud_bag *bag, const char *topic, enum dx_mcap_order order,
                 struct dx_err *err)
{
    char found[512] = "";
    const struct dx_mcap_channel *c = choose(bag->reader, topic, found, sizeof(found));
    const struct dx_mcap_query query = {
        .order = order, .channels = c ? &c->id : NULL, .n_channels = 1};
    int rc;

    if (!c && dx_mcap_reader_topic(bag->reader, DX_RECORDING_TOPIC))
        return dx_err_set(err, -EBADMSG,
                          "%s: a recording of dexeld among scans, expected either in a folder",
                          bag->path);
    if (!c && topic && *topic)
        return dx_err_set(err, -EBADMSG, "%s: found no " DX_ROS_CLOUD_NAME " on topic '%s'%s%s",
                          bag->path, topic, *found ? ", but on " : "", found);
    if (!c && *found)
        return dx_err_set(err, -EBADMSG,
                          "%s: found clouds on several topics, expected one to be chosen: %s",
                          bag->path, found);
    if (!c)
        return dx_err_set(err, -EBADMSG,
                          "%s: found no channel of " DX_ROS_CLOUD_NAME
                          " in CDR, and no recording of dexeld",
                          bag->path);
    rc = dx_mcap_iter_new(&bag->iter, bag->reader, &query);
    return rc ? dx_err_set(err, rc, "%s: %s", bag->path, strerror(-rc)) : 0;
}

static int open_bag(struct dx_cloud_bag *bag, const char *topic, enum dx_mcap_order order,
                    struct dx_err *err)
{
    struct dx_mcap_source source;
    int rc;

    if (bag->fd < 0)
        return bag->fd;
    rc = dx_mcap_source_fd(&source, bag->fd);
    if (rc)
        return dx_err_set(err, rc, "%s: %s", bag->path, strerror(-rc));
    rc = dx_mcap_reader_open(&bag->reader, &source, NULL, err);
    if (rc) {
        dx_err_prefix(err, bag->path);
        return rc;
    }
    return start(bag, topic, order, err);
}

int dx_cloud_bag_open(struct dx_cloud_bag **out, const char *path, const char *topic,
                      enum dx_mcap_order order, struct dx_err *err)
{
    struct dx_cloud_bag *bag = calloc(1, sizeof(*bag));
    int rc;

    if (!bag)
        return dx_err_set(err, -ENOMEM, "%s: no memory", path);
    bag->path = strdup(path);
    bag->fd = dx_open_regular(path, err);
    rc = bag->path ? open_bag(bag, topic, order, err)
                   : dx_err_set(err, -ENOMEM, "%s: no memory", path);
    if (rc) {
        dx_cloud_bag_close(bag);
        return rc;
    }
    *out = bag;
    return 0;
}

void dx_cloud_bag_close(struct dx_cloud_bag *bag)
{
    if (!bag)
        return;
    dx_mcap_iter_free(bag->iter);
    dx_mcap_reader_free(bag->reader);
    if (bag->fd >= 0)
        close(bag->fd);
    free(bag->path);
    free(bag);
}

/* What was passed over is told at the end, in place of it: that is no whole sequence. */
static int end(const struct dx_cloud_bag *bag, struct dx_err *err)
{
    const struct dx_mcap_damage *first = dx_mcap_reader_damage(bag->reader, 0);

    if (!first)
        return DX_MCAP_E_END;
    return dx_err_set(err, -EBADMSG, "%s: damaged in %llu places, first at byte %llu: %s",
                      bag->path, (unsigned long long)dx_mcap_reader_damages(bag->reader),
                      (unsigned long long)first->offset, first->text);
}

int dx_cloud_bag_next(struct dx_cloud_bag *bag, struct dx_mcap_message *out, struct dx_err *err)
{
    int rc = dx_mcap_iter_next(bag->iter, out);

    if (rc == DX_MCAP_E_END)
        return end(bag, err);
    return rc < 0 ? dx_err_set(err, rc, "%s: its messages: %s", bag->path,
                               dx_mcap_iter_why(bag->iter, rc))
                  : rc;
}
