/*
 * Our side of tests/peers/mcap.sh: writes a recording with everything in it, or lists one in the
 * same words as mcap_peer.mjs does.
 *   mcap_peer write FILE none|lz4|zstd
 *   mcap_peer cloud FILE            a PointCloud2 of 2 x 3 points, twice
 *   mcap_peer scene FILE            SceneUpdates: with colours, without, and of nothing
 *   mcap_peer list|stream FILE      by log time and index, or in the order of the file
 */
#include "core/base/rng.h"
#include "drivers/file/crc32.h"
#include "drivers/file/mcap_read.h"
#include "drivers/file/mcap_write.h"
#include "drivers/file/ros_cloud.h"
#include "drivers/file/ros_scene.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { N_MESSAGES = 4000, MAX_LEN = 3000, LARGE = 2500000 };

static void die(const char *what, int rc)
{
    fprintf(stderr, "mcap_peer: %s: %s\n", what, strerror(-rc));
    exit(1);
}

/* ---- write ------------------------------------------------------------------------------------
 */

static void must(const char *what, int rc)
{
    if (rc)
        die(what, rc < 0 ? rc : -ENOSPC);
}

static struct dx_mcap_bytes bytes_of(const char *text)
{
    return (struct dx_mcap_bytes){(const uint8_t *)text, strlen(text)};
}

static void declare(struct dx_mcap_writer *w)
{
    static const char *const topics[] = {"/dexel/raw/roof", "/points", "/gpio/events"};
    const struct dx_mcap_schema schema = {1, dx_mcap_text("pkg/msg/Thing"), dx_mcap_text("ros2msg"),
                                          bytes_of("uint8 x\n")};
    const struct dx_mcap_pair pair = {dx_mcap_text("clock"), dx_mcap_text("monotonic")};
    uint8_t map[64];
    struct dx_writer out = dx_writer_init(map, sizeof(map));

    dx_mcap_put_pairs(&out, &pair, 1);
    must("schema", dx_mcap_writer_schema(w, &schema));
    for (uint16_t k = 0; k < 3; k++) {
        const struct dx_mcap_channel c = {.id = (uint16_t)(k * 7),
                                          .schema_id = k == 1,
                                          .topic = dx_mcap_text(topics[k]),
                                          .message_encoding =
                                              dx_mcap_text(k == 1 ? "cdr" : "x-dexel-raw"),
                                          .metadata = {map, k == 0 ? (size_t)(out.p - map) : 0}};

        must("channel", dx_mcap_writer_channel(w, &c));
    }
}

/* Stamps of the channels are behind each other by up to 40 messages; no two are the same. */
static void put_message(struct dx_mcap_writer *w, uint32_t k, struct dx_rng *rng, uint8_t *data)
{
    uint32_t behind = k % 3 * 20;
    size_t len = k == N_MESSAGES / 2 ? LARGE : dx_rng_below(rng, MAX_LEN);
    struct dx_mcap_message m = {(uint16_t)(k % 3 * 7), k, 0, 0, {data, len}};

    m.log_time = UINT64_C(1700000000000000000) + (uint64_t)(k + 60 - behind) * 1000000 + k % 3;
    m.publish_time = m.log_time - 7;
    for (size_t i = 0; i < len; i++)
        data[i] = (uint8_t)(i % 5 ? i / 16 + k : dx_rng_u64(rng));
    must("message", dx_mcap_writer_message(w, &m));
}

static void write_file(const char *path, const char *compression)
{
    struct dx_mcap_writer_config c = {.chunk_len = 65536};
    const struct dx_mcap_attachment a = {1, 2, dx_mcap_text("config.yaml"),
                                         dx_mcap_text("text/plain"), bytes_of("streams: {}\n")};
    const struct dx_mcap_pair pairs[] = {{dx_mcap_text("model"), dx_mcap_text("hall")},
                                         {dx_mcap_text("serial"), dx_mcap_text("\xc3\xa9 42")}};
    struct dx_mcap_metadata m = {.name = dx_mcap_text("device")};
    struct dx_rng rng = dx_rng_init(1, 1);
    struct dx_mcap_writer *w;
    struct dx_mcap_sink sink;
    struct dx_err err;
    uint8_t map[100], *data = malloc(LARGE);
    struct dx_writer out = dx_writer_init(map, sizeof(map));
    int fd = open(path, O_RDWR | O_CREAT | O_TRUNC, 0666);
    int kind =
        dx_mcap_compression_find(dx_mcap_text(strcmp(compression, "none") == 0 ? "" : compression));

    if (fd < 0 || !data || kind < 0)
        die(path, fd < 0 ? -errno : -EINVAL);
    c.compression = (enum dx_mcap_compression)kind;
    sink = dx_mcap_sink_fd(fd);
    must("open", dx_mcap_writer_new(&w, &c, &err));
    declare(w);
    dx_mcap_put_pairs(&out, pairs, 2);
    m.map = (struct dx_mcap_bytes){map, (size_t)(out.p - map)};
    must("begin", dx_mcap_writer_begin(w, &sink));
    must("metadata", dx_mcap_writer_metadata(w, &m));
    for (uint32_t k = 0; k < N_MESSAGES; k++) {
        put_message(w, k, &rng, data);
        if (k == 1000)
            must("attachment", dx_mcap_writer_attachment(w, &a));
    }
    must("finish", dx_mcap_writer_finish(w));
    dx_mcap_writer_free(w);
    free(data);
    if (close(fd) != 0)
        die(path, -errno);
}

/* Points (row, col, 0.5) and an attribute; the last one without return. */
static size_t make_cloud(uint8_t *out, size_t room)
{
    struct dx_ros_cloud c = {.stamp_ns = UINT64_C(1700000000500000000),
                             .frame_id = "scanner",
                             .frame_id_len = 7,
                             .height = 2,
                             .width = 3};
    uint8_t *p;

    dx_ros_cloud_add_field(&c, "x", DX_ROS_FLOAT32);
    dx_ros_cloud_add_field(&c, "y", DX_ROS_FLOAT32);
    dx_ros_cloud_add_field(&c, "z", DX_ROS_FLOAT32);
    dx_ros_cloud_add_field(&c, "intensity", DX_ROS_UINT16);
    p = dx_ros_cloud_put(&c, out, room);
    if (!p)
        die("cloud", -ENOSPC);
    for (uint32_t k = 0; k < 6; k++, p += c.point_step) {
        const uint32_t row = k / 3, col = k % 3;
        const float nan = __builtin_nanf(""), xyz[3] = {(float)row, (float)col, 0.5f};

        for (int i = 0; i < 3; i++)
            dx_put_u32(p + 4 * i, dx_f32_bits(k == 5 ? nan : xyz[i]));
        dx_put_u16(p + 12, (uint16_t)(k * 1000));
    }
    return dx_ros_cloud_len(&c);
}

/* A file of one channel of a schema. */
static struct dx_mcap_writer *begin_ros(const char *path, const char *topic, const char *name,
                                        const char *text)
{
    const struct dx_mcap_writer_config config = {.profile = "ros2"};
    const struct dx_mcap_schema schema = {1, dx_mcap_text(name), dx_mcap_text("ros2msg"),
                                          bytes_of(text)};
    const struct dx_mcap_pair qos = {dx_mcap_text("offered_qos_profiles"), dx_mcap_text("")};
    uint8_t map[64];
    struct dx_writer out = dx_writer_init(map, sizeof(map));
    struct dx_mcap_channel channel = {.id = 1,
                                      .schema_id = 1,
                                      .topic = dx_mcap_text(topic),
                                      .message_encoding = dx_mcap_text("cdr")};
    const struct dx_mcap_sink sink = dx_mcap_sink_fd(open(path, O_RDWR | O_CREAT | O_TRUNC, 0666));
    struct dx_mcap_writer *w;
    struct dx_err err;

    dx_mcap_put_pairs(&out, &qos, 1);
    channel.metadata = (struct dx_mcap_bytes){map, (size_t)(out.p - map)};
    must("open", dx_mcap_writer_new(&w, &config, &err));
    must("schema", dx_mcap_writer_schema(w, &schema));
    must("channel", dx_mcap_writer_channel(w, &channel));
    must("begin", dx_mcap_writer_begin(w, &sink));
    return w;
}

static void end_ros(struct dx_mcap_writer *w)
{
    must("finish", dx_mcap_writer_finish(w));
    dx_mcap_writer_free(w);
}

static void write_cloud(const char *path)
{
    struct dx_mcap_writer *w = begin_ros(path, "/points", DX_ROS_CLOUD_NAME, dx_ros_cloud_schema);
    uint8_t data[1000];
    struct dx_mcap_message m = {.channel_id = 1, .data = {data, make_cloud(data, sizeof(data))}};

    for (m.sequence = 0; m.sequence < 2; m.sequence++)
        must("message", dx_mcap_writer_message(w, &m));
    end_ros(w);
}

static void put_scene(struct dx_mcap_writer *w, const struct dx_ros_scene *s)
{
    uint8_t data[2000];
    struct dx_mcap_message m = {.channel_id = 1,
                                .data = {data, dx_ros_scene_put(s, data, sizeof(data))}};

    if (m.data.len > sizeof(data))
        die("scene", -ENOSPC);
    must("message", dx_mcap_writer_message(w, &m));
}

/* Two triangles, once with a colour for each point; then a deletion alone. */
static void write_scene(const char *path)
{
    static const float points[] = {0, 0, 0.5f, 1, 0, 0.5f, 0, 1, 0.5f, 1, 1, 0.25f};
    static const float colors[] = {1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 0.5f, 1, 1, 1, 1};
    static const uint32_t indices[] = {0, 1, 2, 2, 1, 3};
    struct dx_ros_scene s = {.stamp_ns = UINT64_C(1700000000500000000),
                             .frame_id = "scanner",
                             .id = "mesh/7",
                             .clears = true,
                             .position = {0.5, -1, 2},
                             .orientation = {0, 0, 0, 1},
                             .points = points,
                             .n_points = 4,
                             .indices = indices,
                             .n_indices = 6,
                             .color = {0, 0.5, 1, 1},
                             .colors = colors};
    struct dx_mcap_writer *w = begin_ros(path, "/mesh", DX_ROS_SCENE_NAME, dx_ros_scene_schema);

    put_scene(w, &s);
    s.id = "mesh/8";
    s.clears = false;
    s.colors = NULL;
    put_scene(w, &s);
    s.clears = true;
    s.n_indices = 0;
    put_scene(w, &s);
    end_ros(w);
}

/* ---- list -------------------------------------------------------------------------------------
 */

static void print_text(struct dx_mcap_text t)
{
    printf("%.*s", (int)t.len, t.p);
}

static void list_messages(struct dx_mcap_reader *r, bool in_file_order)
{
    const struct dx_mcap_query q = {.order = in_file_order ? DX_MCAP_FILE_ORDER : DX_MCAP_LOG_TIME};
    struct dx_mcap_iter *it;
    struct dx_mcap_message m;
    int rc;

    must("messages", dx_mcap_iter_new(&it, r, &q));
    while ((rc = dx_mcap_iter_next(it, &m)) == 0) {
        printf("M ");
        print_text(dx_mcap_reader_find(r, m.channel_id)->topic);
        printf(" %u %" PRIu64 " %" PRIu64 " %zu %08x\n", m.sequence, m.log_time, m.publish_time,
               m.data.len, dx_crc32(0, m.data.p, m.data.len));
    }
    if (rc < 0)
        die("messages", rc);
    dx_mcap_iter_free(it);
}

static void list_channels(struct dx_mcap_reader *r)
{
    const struct dx_mcap_channel *c;

    for (uint32_t k = 0; (c = dx_mcap_reader_channel(r, k)); k++) {
        const struct dx_mcap_schema *s = dx_mcap_reader_find_schema(r, c->schema_id);
        struct dx_reader map = dx_reader_init(c->metadata.p, c->metadata.len);
        struct dx_mcap_pair pair;

        printf("C %u ", c->id);
        print_text(c->topic);
        putchar(' ');
        print_text(c->message_encoding);
        if (s) {
            putchar(' ');
            print_text(s->name);
            putchar(' ');
            print_text(s->encoding);
            printf(" %08x", dx_crc32(0, s->data.p, s->data.len));
        }
        while (dx_mcap_next_pair(&pair, &map) == 0) {
            putchar(' ');
            print_text(pair.key);
            putchar('=');
            print_text(pair.value);
        }
        putchar('\n');
    }
}

static void list_items(struct dx_mcap_reader *r)
{
    const struct dx_mcap_item_index *item;
    struct dx_mcap_attachment a;
    struct dx_mcap_metadata m;
    struct dx_mcap_pair pair;
    struct dx_err err;

    for (uint32_t k = 0; (item = dx_mcap_reader_attachment(r, k)); k++) {
        must("attachment", dx_mcap_reader_read_attachment(r, item, &a, &err));
        printf("A ");
        print_text(a.name);
        putchar(' ');
        print_text(a.media_type);
        printf(" %" PRIu64 " %" PRIu64 " %zu %08x\n", a.log_time, a.create_time, a.data.len,
               dx_crc32(0, a.data.p, a.data.len));
    }
    for (uint32_t k = 0; (item = dx_mcap_reader_metadata(r, k)); k++) {
        struct dx_reader map;

        must("metadata", dx_mcap_reader_read_metadata(r, item, &m, &err));
        printf("D ");
        print_text(m.name);
        map = dx_reader_init(m.map.p, m.map.len);
        while (dx_mcap_next_pair(&pair, &map) == 0) {
            putchar(' ');
            print_text(pair.key);
            putchar('=');
            print_text(pair.value);
        }
        putchar('\n');
    }
}

static void list_file(const char *path, bool in_file_order)
{
    const struct dx_mcap_read_options o = {.scan = in_file_order};
    struct dx_mcap_source source;
    struct dx_mcap_reader *r;
    struct dx_err err;
    const struct dx_mcap_damage *d;
    int fd = open(path, O_RDONLY);
    int rc = fd < 0 ? -errno : dx_mcap_source_fd(&source, fd);

    if (rc)
        die(path, rc);
    if (dx_mcap_reader_open(&r, &source, &o, &err) < 0) {
        fprintf(stderr, "%s: %s\n", path, err.text);
        exit(1);
    }
    list_messages(r, in_file_order);
    list_channels(r);
    list_items(r);
    for (uint64_t k = 0; (d = dx_mcap_reader_damage(r, k)); k++)
        fprintf(stderr, "%s: byte %" PRIu64 ": %s\n", path, d->offset, d->text);
    rc = dx_mcap_reader_damages(r) > 0;
    dx_mcap_reader_free(r);
    close(fd);
    exit(rc);
}

int main(int argc, char **argv)
{
    if (argc == 4 && strcmp(argv[1], "write") == 0)
        write_file(argv[2], argv[3]);
    else if (argc == 3 && strcmp(argv[1], "cloud") == 0)
        write_cloud(argv[2]);
    else if (argc == 3 && strcmp(argv[1], "scene") == 0)
        write_scene(argv[2]);
    else if (argc == 3)
        list_file(argv[2], strcmp(argv[1], "stream") == 0);
    else
        return 2;
    return 0;
}
