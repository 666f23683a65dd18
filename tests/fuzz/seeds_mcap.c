/*
 * Writes the seeds of fuzz_mcap: small files in each compression, whole and cut, with and without
 * CRCs. cc -std=gnu17 -I. -D_GNU_SOURCE -o seeds_mcap tests/fuzz/seeds_mcap.c
 * build/lib/libdxdrivers.a build/lib/libdexel.a -lcmocka -lzstd -llz4 -lz -lm -pthread
 *   ./seeds_mcap tests/fuzz/corpus/mcap
 */
#include "tests/unit/mcap_fixture.h"

static const char *folder;

static void save(const char *name, const uint8_t *bytes, size_t len)
{
    char path[512];
    FILE *f;

    snprintf(path, sizeof(path), "%s/%s", folder, name);
    f = fopen(path, "wb");
    if (!f || fwrite(bytes, 1, len, f) != len || fclose(f) != 0) {
        perror(path);
        exit(1);
    }
}

static void write_small(struct mem_file *f, enum dx_mcap_compression c)
{
    const struct dx_mcap_writer_config config = small_config(c);
    const struct dx_mcap_attachment a = {5, 6, dx_mcap_text("a"), dx_mcap_text("text/plain"),
                                         bytes_of("words")};
    const struct dx_mcap_pair pair = {dx_mcap_text("key"), dx_mcap_text("value")};
    const struct dx_mcap_sink sink = mem_sink(f);
    struct dx_mcap_writer *w = new_writer(&config);
    uint8_t map[64];
    struct dx_writer out = dx_writer_init(map, sizeof(map));
    struct dx_mcap_metadata m = {.name = dx_mcap_text("m")};

    dx_mcap_put_pairs(&out, &pair, 1);
    m.map = (struct dx_mcap_bytes){map, (size_t)(out.p - map)};
    declare(w, 1, true);
    declare(w, 4, false);
    dx_mcap_writer_begin(w, &sink);
    dx_mcap_writer_metadata(w, &m);
    for (uint32_t k = 0; k < 8; k++)
        put(w, k % 2 ? 1 : 4, k, k % 3 * 10);
    dx_mcap_writer_attachment(w, &a);
    dx_mcap_writer_finish(w);
    dx_mcap_writer_free(w);
}

int main(int argc, char **argv)
{
    static const char *const names[] = {"none", "lz4", "zstd"};
    uint8_t bare[sizeof(worked_file)];
    char name[32];

    if (argc != 2) {
        fprintf(stderr, "usage: seeds_mcap FOLDER\n");
        return 2;
    }
    folder = argv[1];
    for (enum dx_mcap_compression c = 0; c < DX_MCAP_N_COMPRESSIONS; c++) {
        struct mem_file f = mem_new();

        write_small(&f, c);
        snprintf(name, sizeof(name), "%s.mcap", names[c]);
        save(name, f.bytes, f.len);
        snprintf(name, sizeof(name), "%s-cut.mcap", names[c]);
        save(name, f.bytes, f.len / 2);
        mem_free(&f);
    }
    save("worked.mcap", worked_file, sizeof(worked_file));
    /* without CRCs a changed byte goes deeper: of the chunk, the data, the summary */
    memcpy(bare, worked_file, sizeof(bare));
    memset(bare + 0x40, 0, 4);
    memset(bare + 0xdc, 0, 4);
    memset(bare + sizeof(bare) - 12, 0, 4);
    save("no-crc.mcap", bare, sizeof(bare));
    save("no-crc-cut.mcap", bare, 0xd3);
    return 0;
}
