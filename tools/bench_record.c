/*
 * dexel bench record: what writing and reading a recording costs, beside `zstd -1`, `zstd -d` and
 * `cat` on the same bytes, in turn. The blocks are depth frames of a simulated scan; the files lie
 * in $TMPDIR, best in memory.
 */
#include "tools/bench.h"

#include "drivers/file/mcap_read.h"
#include "drivers/file/mcap_write.h"
#include "drivers/file/recording.h"
#include "tools/args.h"
#include "tools/bench_args.h"
#include "tools/bench_frame.h"
#include "tools/now.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char help[] =
    "usage: dexel bench record [OPTIONS]\n"
    "Measures how fast recordings are written and read, beside zstd and cat on the same bytes.\n"
    "The files lie in $TMPDIR, or /tmp.\n\n" DX_BENCH_ARGS_HELP;

static const struct dx_bench_command command = {"dexel bench record", help, NULL, false};

/* Of blocks, in a file: more than any cache holds. */
#define BYTES ((size_t)128 << 20)

static const struct dx_report_column columns[] = {
    {"what", "what", 0},
    {"of the bytes, %", "percent", 1},
    {"written, GB/s", "write_gb_per_s", 2},
    {"read, GB/s", "read_gb_per_s", 2},
    {NULL, NULL, 0},
};

static const struct {
    const char *name;
    enum dx_mcap_compression compression;
} kinds[] = {
    {"recording, none", DX_MCAP_NONE},
    {"recording, lz4", DX_MCAP_LZ4},
    {"recording, zstd", DX_MCAP_ZSTD},
};

enum { N_KINDS = 3, ZSTD = N_KINDS, CAT, N_ROWS };

struct bench {
    struct dx_bench_frames frames;
    size_t block_len;
    uint32_t n_blocks;
    uint8_t *message; /* one piece */
    char folder[256];
    double percent[N_ROWS];
    double write_s[N_ROWS][DX_BENCH_MAX_ROUNDS], read_s[N_ROWS][DX_BENCH_MAX_ROUNDS];
};

/* ---- our recordings ---------------------------------------------------------------------------
 */

static int put_block(struct bench *b, struct dx_mcap_writer *w, uint32_t number)
{
    const uint8_t *bytes = b->frames.plane[number % 2].range;
    int r = 0;

    for (size_t at = 0; at < b->block_len && r == 0; at += DX_RECORDING_PIECE) {
        size_t left = b->block_len - at;
        const struct dx_recording_piece piece = {
            .number = number,
            .block_len = b->block_len,
            .offset = at,
            .bytes = bytes + at,
            .len = left < DX_RECORDING_PIECE ? left : DX_RECORDING_PIECE};
        const struct dx_mcap_message m = {.channel_id = DX_RECORDING_CHANNEL,
                                          .log_time =
                                              (uint64_t)number * 11111111u, /* 90 a second */
                                          .data = {b->message, dx_recording_piece_len(&piece)}};

        dx_recording_put_piece(b->message, &piece);
        r = dx_mcap_writer_message(w, &m);
    }
    return r;
}

static int write_file(struct bench *b, int fd, struct dx_mcap_writer *w)
{
    const struct dx_mcap_channel channel = {.id = DX_RECORDING_CHANNEL,
                                            .topic = dx_mcap_text(DX_RECORDING_TOPIC),
                                            .message_encoding =
                                                dx_mcap_text(DX_RECORDING_ENCODING)};
    const struct dx_mcap_sink sink = dx_mcap_sink_fd(fd);
    int r = dx_mcap_writer_channel(w, &channel);

    if (r == 0)
        r = dx_mcap_writer_begin(w, &sink);
    for (uint32_t n = 0; n < b->n_blocks && r == 0; n++)
        r = put_block(b, w, n);
    return r ? r : dx_mcap_writer_finish(w);
}

static void path_of(const struct bench *b, char path[300], const char *name)
{
    snprintf(path, 300, "%s/%s", b->folder, name);
}

static int time_write(struct bench *b, int kind, uint32_t round)
{
    const struct dx_mcap_writer_config config = {.compression = kinds[kind].compression};
    struct dx_mcap_writer *w = NULL;
    char path[300];
    uint64_t start;
    int fd, r;

    path_of(b, path, kind == DX_MCAP_NONE ? "none" : "packed");
    unlink(path);
    fd = open(path, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (fd < 0)
        return -errno;
    r = dx_mcap_writer_new(&w, &config, NULL);
    start = dx_now_ns();
    if (r == 0)
        r = write_file(b, fd, w);
    b->write_s[kind][round] = dx_seconds_since(start);
    if (r == 0)
        b->percent[kind] =
            100.0 * (double)dx_mcap_writer_progress(w).len / ((double)b->block_len * b->n_blocks);
    dx_mcap_writer_free(w);
    close(fd);
    return r;
}

static int read_file(struct bench *b, int fd)
{
    const struct dx_mcap_query query = {.order = DX_MCAP_FILE_ORDER};
    struct dx_mcap_reader *reader = NULL;
    struct dx_mcap_iter *iter = NULL;
    struct dx_mcap_source source;
    struct dx_mcap_message m;
    size_t len = 0;
    int r = dx_mcap_source_fd(&source, fd);

    if (r == 0)
        r = dx_mcap_reader_open(&reader, &source, NULL, NULL);
    if (r == 0)
        r = dx_mcap_iter_new(&iter, reader, &query);
    while (r == 0 && (r = dx_mcap_iter_next(iter, &m)) == 0) {
        struct dx_recording_piece piece;

        r = dx_recording_get_piece(&piece, m.data.p, m.data.len);
        len += piece.len;
    }
    dx_mcap_iter_free(iter);
    dx_mcap_reader_free(reader);
    if (r == DX_MCAP_E_END)
        r = len == b->block_len * b->n_blocks ? 0 : -EBADMSG;
    return r;
}

static int time_read(struct bench *b, int kind, uint32_t round)
{
    uint64_t start = dx_now_ns();
    char path[300];
    int fd, r;

    path_of(b, path, kind == DX_MCAP_NONE ? "none" : "packed");
    fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return -errno;
    r = read_file(b, fd);
    b->read_s[kind][round] = dx_seconds_since(start);
    close(fd);
    return r;
}

/* ---- the others -------------------------------------------------------------------------------
 */

/* Seconds of a command in the folder of the files; -1: it failed, or is not there. */
static double time_command(const struct bench *b, const char *text)
{
    char line[700];
    uint64_t start = dx_now_ns();

    snprintf(line, sizeof(line), "cd '%s' && %s 2>/dev/null", b->folder, text);
    return system(line) == 0 ? dx_seconds_since(start) : -1;
}

static void time_others(struct bench *b, uint32_t round)
{
    FILE *packed;
    char path[300];

    b->write_s[ZSTD][round] = time_command(b, "zstd -1 -q -c none >none.zst");
    b->read_s[ZSTD][round] = time_command(b, "zstd -d -q -c none.zst >/dev/null");
    b->write_s[CAT][round] = time_command(b, "cat none >copy");
    b->read_s[CAT][round] = time_command(b, "cat none | cat >/dev/null");
    b->percent[CAT] = b->percent[0];
    path_of(b, path, "none.zst");
    packed = fopen(path, "r");
    if (packed && fseek(packed, 0, SEEK_END) == 0)
        b->percent[ZSTD] = 100.0 * (double)ftell(packed) / ((double)b->block_len * b->n_blocks);
    if (packed)
        fclose(packed);
}

/* ---- the benchmark ----------------------------------------------------------------------------
 */

static int run_rounds(struct bench *b, uint32_t n_rounds)
{
    int r = 0;

    for (uint32_t round = 0; round < n_rounds && r == 0; round++) {
        for (int k = 0; k < N_KINDS && r == 0; k++) {
            r = time_write(b, k, round);
            if (r == 0)
                r = time_read(b, k, round);
        }
        time_others(b, round);
    }
    return r;
}

static void tell(struct dx_report_table *t, const struct bench *b, uint32_t n_rounds)
{
    static const char *const names[] = {"zstd -1, zstd -d", "cat to a file, through a pipe"};
    double gb = (double)b->block_len * b->n_blocks * 1e-9;

    for (int k = 0; k < N_ROWS; k++) {
        double w = dx_bench_median(b->write_s[k], n_rounds);
        double r = dx_bench_median(b->read_s[k], n_rounds);
        json_t *row = dx_report_row(t);

        json_object_set_new(row, "what",
                            json_string(k < N_KINDS ? kinds[k].name : names[k - ZSTD]));
        json_object_set_new(row, "rounds", json_integer(n_rounds));
        if (w <= 0 || r <= 0)
            continue; /* no such program here */
        json_object_set_new(row, "percent", json_real(b->percent[k]));
        json_object_set_new(row, "write_gb_per_s", json_real(gb / w));
        json_object_set_new(row, "read_gb_per_s", json_real(gb / r));
    }
}

static int bench_init(struct bench *b, const struct dx_bench_args *a)
{
    const char *tmp = getenv("TMPDIR");
    int r = dx_bench_frames_init(&b->frames, a, a->size[0]);

    if (r)
        return r;
    b->block_len = dx_plane_n_dexels(&b->frames.plane[0]) * b->frames.plane[0].range_bytes;
    b->n_blocks = (uint32_t)(BYTES / b->block_len) + 1;
    b->message = malloc(DX_RECORDING_PIECE + DX_RECORDING_HEAD + DX_RECORDING_MAX_SOURCE);
    if (!b->message)
        return -ENOMEM;
    snprintf(b->folder, sizeof(b->folder), "%s/dexel-bench-XXXXXX", tmp && *tmp ? tmp : "/tmp");
    if (strchr(b->folder, '\'') || !mkdtemp(b->folder)) {
        r = errno ? -errno : -EINVAL;
        b->folder[0] = '\0';
    }
    return r;
}

static void bench_fini(struct bench *b)
{
    static const char *const files[] = {"none", "packed", "none.zst", "copy"};
    char path[300];

    for (size_t k = 0; k < sizeof(files) / sizeof(files[0]) && b->folder[0]; k++) {
        path_of(b, path, files[k]);
        unlink(path);
    }
    if (b->folder[0])
        rmdir(b->folder);
    free(b->message);
    dx_bench_frames_fini(&b->frames);
}

int dx_bench_record(int argc, char **argv)
{
    struct dx_report_table table = {
        .name = "recordings",
        .title = "Writing and reading recordings",
        .text =
            "Blocks of a device per second, each program alone on its files, in turn; medians. "
            "Ours\nchecks every CRC, as written and as read; the share is of the blocks' bytes.",
        .columns = columns};
    struct bench *b = calloc(1, sizeof(*b));
    struct dx_bench_args a;
    struct dx_report report;
    int r = dx_bench_args_parse(&a, &command, argc, argv);

    if (r != 0 || !b) {
        free(b);
        return r == DX_ARG_E_HELP ? 0 : r ? 2 : 1;
    }
    dx_report_init(&report, a.format, command.name, argc, argv);
    r = bench_init(b, &a);
    if (r == 0)
        r = run_rounds(b, a.n_rounds ? a.n_rounds : 5);
    if (r < 0)
        fprintf(stderr, "%s: %s: %s\n", command.name, b->folder, strerror(-r));
    else
        tell(&table, b, a.n_rounds ? a.n_rounds : 5);
    bench_fini(b);
    free(b);
    dx_report_table(&report, &table);
    return dx_report_close(&report) < 0 || r < 0 ? 1 : 0;
}
