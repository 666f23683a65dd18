/* STL: the corners of triangles, as text or as records of 50 bytes behind a header of 84. */
#include "drivers/file/points_priv.h"

#include "core/base/bytes.h"
#include "drivers/file/text_cursor.h"

#include <errno.h>
#include <string.h>

#define HEADER_LEN 84
#define RECORD_LEN 50

/* Its length is what its header says: text that begins with "solid" hardly ever is. */
static bool is_binary(const uint8_t *bytes, size_t len)
{
    return len >= HEADER_LEN &&
           HEADER_LEN + (uint64_t)RECORD_LEN * dx_get_u32(bytes + HEADER_LEN - 4) == len;
}

static bool stl_probe(const uint8_t *bytes, size_t len)
{
    return len >= 6 && (memcmp(bytes, "solid ", 6) == 0 || memcmp(bytes, "solid\n", 6) == 0 ||
                        memcmp(bytes, "solid\r", 6) == 0);
}

static int parse_binary(struct dx_point_list *list, const uint8_t *bytes, struct dx_err *err)
{
    const uint32_t n = dx_get_u32(bytes + HEADER_LEN - 4);
    int rc = dx_point_list_reserve(list, 3 * (uint64_t)n, err);

    if (rc < 0)
        return rc;
    for (size_t t = 0; t < n; t++)
        for (size_t k = 0; k < 9; k++) { /* behind the normal */
            const uint8_t *p = bytes + HEADER_LEN + RECORD_LEN * t + 12 + 4 * k;

            list->xyz[9 * t + k] = (double)dx_f32_from_bits(dx_get_u32(p));
        }
    list->n = 3 * (size_t)n;
    return 0;
}

static int take_vertex(struct dx_point_list *list, struct dx_text_cursor *c)
{
    double p[3];
    int rc = 0;

    for (int k = 0; k < 3 && rc == 0; k++)
        rc = dx_text_number(c, &p[k], "vertex x y z");
    return rc == 0 ? dx_point_list_add(list, p, c->err) : rc;
}

/* Solids, one after the other; what a facet says besides its vertices is passed over. */
static int parse_text(struct dx_point_list *list, const uint8_t *bytes, size_t len,
                      struct dx_err *err)
{
    struct dx_text_cursor c = dx_text_cursor_init(bytes, len, err);
    bool is_open = false;

    while (c.p < c.end) {
        int rc = 0;

        if (!dx_text_next_word(&c))
            ;
        else if (is_open && dx_text_takes(&c, "vertex"))
            rc = take_vertex(list, &c);
        else if (dx_text_takes(&c, is_open ? "endsolid" : "solid"))
            is_open = !is_open;
        else if (!is_open || !(dx_text_takes(&c, "facet") || dx_text_takes(&c, "outer") ||
                               dx_text_takes(&c, "endloop") || dx_text_takes(&c, "endfacet")))
            rc = dx_text_error(&c, c.p, is_open ? "facet, vertex or endsolid" : "solid");
        if (rc < 0)
            return rc;
        dx_text_skip_line(&c);
    }
    return is_open ? dx_text_error(&c, c.p, "endsolid") : 0;
}

static int stl_parse(struct dx_point_list *list, const uint8_t *bytes, size_t len,
                     struct dx_err *err)
{
    if (is_binary(bytes, len))
        return parse_binary(list, bytes, err);
    if (stl_probe(bytes, len))
        return parse_text(list, bytes, len, err);
    return dx_err_set(err, -EBADMSG,
                      "%zu bytes, expected text that begins with \"solid\" or 84 bytes and 50 for "
                      "each triangle",
                      len);
}

const struct dx_points_format dx_points_stl = {".stl", stl_probe, stl_parse};
