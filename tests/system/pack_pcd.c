/* pack_pcd IN OUT: a binary PCD of 4-byte fields, as `dexel sim` writes it, to a compressed one. */
#include <liblzf/lzf.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_LEN (1u << 20)

/* A compressed PCD holds one field after the other, not one point after the other. */
static void transpose(uint8_t *out, const uint8_t *points, size_t n_fields, size_t n_points)
{
    for (size_t p = 0; p < n_points; p++)
        for (size_t f = 0; f < n_fields; f++)
            memcpy(out + 4 * (f * n_points + p), points + 4 * (p * n_fields + f), 4);
}

int main(int argc, char **argv)
{
    static uint8_t in[MAX_LEN], fields[MAX_LEN], packed[MAX_LEN];
    FILE *from = argc == 3 ? fopen(argv[1], "rb") : NULL, *to = NULL;
    size_t len = from ? fread(in, 1, MAX_LEN - 1, from) : 0;
    char *data = len ? strstr((char *)in, "DATA binary\n") : NULL;
    uint32_t sizes[2]; /* packed, whole: little-endian, as this machine is */

    if (!data || !(to = fopen(argv[2], "wb"))) {
        fprintf(stderr, "usage: pack_pcd IN OUT, IN a binary PCD\n");
        return 2;
    }
    sizes[1] = (uint32_t)(len - (size_t)((uint8_t *)data - in) - 12);
    transpose(fields, (uint8_t *)data + 12, 4, sizes[1] / 16);
    sizes[0] = lzf_compress(fields, sizes[1], packed, MAX_LEN);
    fprintf(to, "%.*sDATA binary_compressed\n", (int)(data - (char *)in), (char *)in);
    fwrite(sizes, 4, 2, to);
    fwrite(packed, 1, sizes[0], to);
    fclose(from);
    return fclose(to) != 0;
}
