/*
 * Looks at recordings: every block is whole, their numbers follow each other save where the file
 * tells of a gap, and with --synthetic each holds the number of its own frame. Prints a line
 *   blocks N first A last B lost L damages D end_ns T
 * for all files together; status 1 with a text when something is wrong.
 *   record_check [--synthetic] FILE...
 */
#include "core/base/bytes.h"
#include "drivers/file/mcap_read.h"
#include "drivers/file/recording.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct sum {
    bool synthetic;
    uint64_t n_blocks, first, next, n_missing, n_told, n_damages, end_ns;
    uint64_t got;                      /* of the block under way */
    uint64_t last_gap, last_gap_first; /* blocks of the gap told last, and the first of them */
};

static int wrong(const char *path, const char *text, uint64_t number)
{
    fprintf(stderr, "%s: block %llu: %s\n", path, (unsigned long long)number, text);
    return -1;
}

static int add_piece(struct sum *s, const char *path, const struct dx_mcap_message *m)
{
    struct dx_recording_piece p;

    if (dx_recording_get_piece(&p, m->data.p, m->data.len) != 0)
        return wrong(path, "no piece of a block", m->sequence);
    if (p.offset != s->got)
        return wrong(path, "a piece is missing", p.number);
    if (s->synthetic && (p.len != 16 || dx_get_u64(p.bytes) != p.number))
        return wrong(path, "altered", p.number);
    if (s->n_blocks == 0)
        s->first = s->next = p.number;
    if (p.number < s->next)
        return wrong(path, "out of order", p.number);
    s->n_missing += p.number - s->next;
    s->next = p.number;
    s->got = p.offset + p.len;
    s->end_ns = m->log_time;
    if (s->got == p.block_len) {
        s->got = 0;
        s->next++;
        s->n_blocks++;
    }
    return 0;
}

static void add_gaps(struct sum *s, struct dx_mcap_reader *r)
{
    const struct dx_mcap_item_index *item;
    struct dx_mcap_metadata m;

    for (uint32_t k = 0; (item = dx_mcap_reader_metadata(r, k)) != NULL; k++) {
        struct dx_mcap_pair pair;
        struct dx_reader map;

        if (!dx_mcap_text_is(item->name, DX_RECORDING_GAP) ||
            dx_mcap_reader_read_metadata(r, item, &m, NULL) != 0)
            continue;
        map = dx_reader_init(m.map.p, m.map.len);
        while (dx_mcap_next_pair(&pair, &map) == 0) {
            char text[32];

            dx_mcap_text_copy(text, sizeof(text), pair.value);
            if (dx_mcap_text_is(pair.key, "blocks"))
                s->last_gap = strtoull(text, NULL, 10);
            else if (dx_mcap_text_is(pair.key, "first_block"))
                s->last_gap_first = strtoull(text, NULL, 10);
        }
        s->n_told += s->last_gap;
    }
}

static int add_messages(struct sum *s, const char *path, struct dx_mcap_reader *r)
{
    const struct dx_mcap_query query = {.order = DX_MCAP_FILE_ORDER};
    struct dx_mcap_message m;
    struct dx_mcap_iter *it;
    int rc;

    if (dx_mcap_iter_new(&it, r, &query) != 0)
        return -1;
    while ((rc = dx_mcap_iter_next(it, &m)) == 0)
        if (add_piece(s, path, &m) != 0) {
            rc = -1;
            break;
        }
    dx_mcap_iter_free(it);
    return rc == DX_MCAP_E_END ? 0 : -1;
}

static int add_file(struct sum *s, const char *path)
{
    int fd = open(path, O_RDONLY), rc;
    struct dx_mcap_reader *r;
    struct dx_mcap_source source;
    struct dx_err err = {"cannot be read"};

    if (fd < 0 || dx_mcap_source_fd(&source, fd) != 0 ||
        dx_mcap_reader_open(&r, &source, NULL, &err) != 0) {
        fprintf(stderr, "%s: %s\n", path, err.text);
        return -1;
    }
    rc = add_messages(s, path, r);
    add_gaps(s, r);
    s->n_damages += dx_mcap_reader_damages(r);
    dx_mcap_reader_free(r);
    close(fd);
    return rc;
}

int main(int argc, char **argv)
{
    struct sum s = {.synthetic = argc > 1 && !strcmp(argv[1], "--synthetic")};

    for (int k = 1 + s.synthetic; k < argc; k++)
        if (add_file(&s, argv[k]) != 0)
            return 1;
    if (s.last_gap && s.last_gap_first == s.next) /* at the end, with no block behind it */
        s.n_told -= s.last_gap;
    if (s.n_missing != s.n_told && s.n_damages == 0) {
        fprintf(stderr, "%llu blocks are missing, the files tell of %llu\n",
                (unsigned long long)s.n_missing, (unsigned long long)s.n_told);
        return 1;
    }
    printf("blocks %llu first %llu last %llu lost %llu damages %llu end_ns %llu\n",
           (unsigned long long)s.n_blocks, (unsigned long long)s.first,
           (unsigned long long)(s.next - (s.n_blocks > 0)), (unsigned long long)s.n_missing,
           (unsigned long long)s.n_damages, (unsigned long long)s.end_ns);
    return 0;
}
