/* PCD header (Point Cloud Library, v0.7; older ones lack COUNT and VIEWPOINT). */
#include "drivers/file/pcd_header.h"

#include "core/grid/plane.h"

#include <errno.h>
#include <math.h>
#include <string.h>

/* Values of one field, and bytes of a point: far above any real cloud, and sums of them fit 32
 * bits. */
#define MAX_COUNT  65536u
#define MAX_STRIDE (1u << 20)

/* A header being read: which lines were there. */
struct parse {
    struct dx_pcd_header *h;
    struct dx_text_cursor *c;
    unsigned seen; /* bit of each keyword's place in `keywords` */
    uint64_t points;
    bool any; /* one row will do */
};

static bool word_is(const struct dx_text_cursor *c, const char *word)
{
    size_t len = strlen(word);

    return (size_t)(c->end - c->p) >= len && memcmp(c->p, word, len) == 0 &&
           dx_text_ends_word(c, c->p + len);
}

static const char *word_end(const struct dx_text_cursor *c)
{
    const char *q = c->p;

    while (!dx_text_ends_word(c, q))
        q++;
    return q;
}

static int read_fields(struct parse *s)
{
    struct dx_pcd_header *h = s->h;

    while (dx_text_next_word(s->c)) {
        const char *q = word_end(s->c);
        size_t len = (size_t)(q - s->c->p);

        if (h->n_fields == DX_PCD_MAX_FIELDS)
            return dx_text_error(s->c, s->c->p, "at most 64 fields");
        if (len >= DX_PCD_MAX_NAME)
            return dx_text_error(s->c, s->c->p, "a field name of at most 31 bytes");
        memcpy(h->fields[h->n_fields].name, s->c->p, len);
        h->fields[h->n_fields++].count = 1;
        s->c->p = q;
    }
    return h->n_fields ? 0 : dx_text_error(s->c, s->c->p, "names of fields");
}

static int read_sizes(struct parse *s)
{
    for (uint32_t k = 0; k < s->h->n_fields; k++) {
        uint32_t *size = &s->h->fields[k].size;
        const char *p = dx_text_next_word(s->c);
        int rc = dx_text_count(s->c, size, 8, "a size of 1, 2, 4 or 8 for each field");

        if (rc)
            return rc;
        if (*size & (*size - 1))
            return dx_text_error(s->c, p, "a size of 1, 2, 4 or 8 for each field");
    }
    return 0;
}

static int read_types(struct parse *s)
{
    for (uint32_t k = 0; k < s->h->n_fields; k++) {
        if (!dx_text_next_word(s->c) ||
            !(word_is(s->c, "I") || word_is(s->c, "U") || word_is(s->c, "F")))
            return dx_text_error(s->c, s->c->p, "a type I, U or F for each field");
        s->h->fields[k].type = *s->c->p++;
    }
    return 0;
}

static int read_counts(struct parse *s)
{
    for (uint32_t k = 0; k < s->h->n_fields; k++) {
        int rc = dx_text_count(s->c, &s->h->fields[k].count, MAX_COUNT,
                               "a count of 1 to 65536 for each field");

        if (rc)
            return rc;
    }
    return 0;
}

static int read_width(struct parse *s)
{
    if (s->any)
        return dx_text_count(s->c, &s->h->width, DX_PLANE_MAX_DEXELS, "a width of 1 to 268435456");
    return dx_text_count(s->c, &s->h->width, DX_PLANE_MAX_SIDE, "a width of 1 to 65535");
}

static int read_height(struct parse *s)
{
    return dx_text_count(s->c, &s->h->height, DX_PLANE_MAX_SIDE, "a height of 2 to 65535");
}

static int read_viewpoint(struct parse *s)
{
    for (int k = 0; k < 7; k++) {
        const char *p = dx_text_next_word(s->c);
        int rc = dx_text_number(s->c, &s->h->viewpoint[k], "7 numbers (tx ty tz qw qx qy qz)");

        if (rc)
            return rc;
        if (!(fabs(s->h->viewpoint[k]) < 1e100))
            return dx_text_error(s->c, p, "a finite number");
    }
    return 0;
}

static int read_n_points(struct parse *s)
{
    uint32_t n;
    int rc = dx_text_count(s->c, &n, DX_PLANE_MAX_DEXELS, "a number of points, 1 to 268435456");

    s->points = n;
    return rc;
}

static int read_data(struct parse *s)
{
    static const char *const words[] = {"ascii", "binary", "binary_compressed"};

    dx_text_next_word(s->c);
    for (unsigned k = 0; k < 3; k++)
        if (word_is(s->c, words[k])) {
            s->h->data = (enum dx_pcd_data)k;
            s->c->p += strlen(words[k]);
            return 0;
        }
    return dx_text_error(s->c, s->c->p, "ascii, binary or binary_compressed");
}

static int read_version(struct parse *s)
{
    if (!dx_text_next_word(s->c))
        return dx_text_error(s->c, s->c->p, "a version");
    s->c->p = word_end(s->c);
    return 0;
}

enum { VERSION, FIELDS, SIZE, TYPE, COUNT, WIDTH, HEIGHT, VIEWPOINT, POINTS, DATA, N_KEYWORDS };

static const struct keyword {
    const char *word;
    int (*read)(struct parse *s);
    unsigned after; /* keywords that must have come before */
} keywords[N_KEYWORDS] = {
    [VERSION] = {"VERSION", read_version, 0},
    [FIELDS] = {"FIELDS", read_fields, 0},
    [SIZE] = {"SIZE", read_sizes, 1u << FIELDS},
    [TYPE] = {"TYPE", read_types, 1u << FIELDS},
    [COUNT] = {"COUNT", read_counts, 1u << FIELDS},
    [WIDTH] = {"WIDTH", read_width, 0},
    [HEIGHT] = {"HEIGHT", read_height, 0},
    [VIEWPOINT] = {"VIEWPOINT", read_viewpoint, 0},
    [POINTS] = {"POINTS", read_n_points, 0},
    [DATA] = {"DATA", read_data,
              1u << FIELDS | 1u << SIZE | 1u << TYPE | 1u << WIDTH | 1u << HEIGHT | 1u << POINTS},
};

static int find_keyword(const struct dx_text_cursor *c)
{
    for (int k = 0; k < N_KEYWORDS; k++)
        if (word_is(c, keywords[k].word))
            return k;
    return N_KEYWORDS;
}

/* One line; the keyword that it was, N_KEYWORDS for a comment, or negative. */
static int read_line(struct parse *s)
{
    unsigned missing;
    int k, rc;

    dx_text_skip_blank_lines(s->c);
    if (s->c->p < s->c->end && *s->c->p == '#') {
        dx_text_skip_line(s->c);
        return N_KEYWORDS;
    }
    k = find_keyword(s->c);
    if (k == N_KEYWORDS)
        return dx_text_error(s->c, s->c->p, "a keyword of the PCD header");
    if (s->seen & 1u << k)
        return dx_text_error(s->c, s->c->p, "each keyword once");
    missing = keywords[k].after & ~s->seen;
    if (missing)
        return dx_text_error(s->c, s->c->p, keywords[__builtin_ctz(missing)].word);
    s->seen |= 1u << k;
    s->c->p += strlen(keywords[k].word);
    rc = keywords[k].read(s);
    if (rc == 0)
        rc = dx_text_end_line(s->c);
    return rc ? rc : k;
}

/* Offsets of the fields, and what the header says as a whole. */
static int check(struct parse *s)
{
    struct dx_pcd_header *h = s->h;
    unsigned long long line = s->c->line - 1;

    for (uint32_t k = 0; k < h->n_fields; k++) {
        struct dx_pcd_field *f = &h->fields[k];

        if (f->type == 'F' && f->size < 4)
            return dx_err_set(s->c->err, -EBADMSG,
                              "line %llu: field %s of type F and size %u, expected 4 or 8", line,
                              f->name, f->size);
        f->offset = h->stride;
        f->index = h->n_values;
        h->stride += f->size * f->count;
        h->n_values += f->count;
        if (h->stride > MAX_STRIDE)
            return dx_err_set(s->c->err, -EBADMSG,
                              "line %llu: %u bytes a point, expected at most %u", line, h->stride,
                              MAX_STRIDE);
    }
    if (h->height < 2 && !s->any)
        return dx_err_set(s->c->err, -EBADMSG,
                          "line %llu: HEIGHT 1, an unorganized cloud, expected rows and columns "
                          "of a range image",
                          line);
    if ((uint64_t)h->width * h->height != s->points || s->points > DX_PLANE_MAX_DEXELS)
        return dx_err_set(s->c->err, -EBADMSG,
                          "line %llu: POINTS %llu, expected WIDTH x HEIGHT = %llu", line,
                          (unsigned long long)s->points, (unsigned long long)h->width * h->height);
    return 0;
}

static int read_header(struct dx_pcd_header *h, struct dx_text_cursor *c, bool any)
{
    struct parse s = {.h = h, .c = c, .any = any};
    int k;

    *h = (struct dx_pcd_header){.viewpoint = {0, 0, 0, 1, 0, 0, 0}};
    do
        k = read_line(&s);
    while (k >= 0 && k != DATA);
    return k < 0 ? k : check(&s);
}

int dx_pcd_header_read(struct dx_pcd_header *h, struct dx_text_cursor *c)
{
    return read_header(h, c, false);
}

int dx_pcd_header_read_any(struct dx_pcd_header *h, struct dx_text_cursor *c)
{
    return read_header(h, c, true);
}

const struct dx_pcd_field *dx_pcd_field_find(const struct dx_pcd_header *h, const char *name)
{
    for (uint32_t k = 0; k < h->n_fields; k++)
        if (strcmp(h->fields[k].name, name) == 0)
            return &h->fields[k];
    return NULL;
}
