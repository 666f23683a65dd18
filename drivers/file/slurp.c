/* Reading whole files. The one file that includes zlib. */
#include "drivers/file/slurp.h"

#include "drivers/file/open_regular.h"

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#define PIECE       ((size_t)256 << 10)
#define GZIP_WINDOW (15 + 16) /* zlib: largest window, gzip header and trailer */

/* One file being read. */
struct source {
    int fd;
    const char *path;
    size_t max;
    struct dx_err *err;
};

static int too_large(const struct source *f)
{
    return dx_err_set(f->err, -EFBIG, "%s: more than %zu bytes, the limit", f->path, f->max);
}

/* Room for at least one byte more, at most one more than the limit (which then shows). */
static int grow(struct dx_slurp *s, const struct source *f, size_t hint)
{
    size_t cap = s->cap + s->cap / 2 + PIECE;
    uint8_t *bytes;

    if (s->len > f->max)
        return too_large(f);
    if (s->len < s->cap)
        return 0;
    cap = cap > hint ? cap : hint;
    if (cap > f->max)
        cap = f->max + 1;
    bytes = realloc(s->bytes, cap);
    if (!bytes)
        return dx_err_set(f->err, -ENOMEM, "%s: no memory for %zu bytes", f->path, cap);
    s->bytes = bytes;
    s->cap = cap;
    return 0;
}

/* Fills up to `len` bytes; the count, 0 at the end of the file, or negative. */
static ssize_t read_some(const struct source *f, uint8_t *bytes, size_t len)
{
    ssize_t n;

    do
        n = read(f->fd, bytes, len);
    while (n < 0 && errno == EINTR);
    if (n < 0)
        return dx_err_set(f->err, -errno, "%s: %s", f->path, strerror(errno));
    return n;
}

static int read_plain(struct dx_slurp *s, const struct source *f, size_t hint)
{
    for (;;) {
        int rc = grow(s, f, hint);
        ssize_t n;

        if (rc)
            return rc;
        n = read_some(f, s->bytes + s->len, s->cap - s->len);
        if (n <= 0)
            return (int)n;
        s->len += (size_t)n;
    }
}

/* Inflates what `z` has as input; `read_len`: bytes of the file read so far. 1 when a member ended.
 */
static int inflate_piece(struct dx_slurp *s, const struct source *f, z_stream *z, uint64_t read_len)
{
    int status;

    do {
        int rc = grow(s, f, 0);
        size_t room;

        if (rc)
            return rc;
        room = s->cap - s->len < PIECE ? s->cap - s->len : PIECE;
        z->next_out = s->bytes + s->len;
        z->avail_out = (uInt)room;
        status = inflate(z, Z_NO_FLUSH);
        s->len += room - z->avail_out;
        if (status != Z_OK && status != Z_STREAM_END && status != Z_BUF_ERROR)
            return dx_err_set(f->err, status == Z_MEM_ERROR ? -ENOMEM : -EBADMSG,
                              "%s: byte %llu: damaged gzip data (%s)", f->path,
                              (unsigned long long)(read_len - z->avail_in),
                              z->msg ? z->msg : zError(status));
    } while (status == Z_OK && (z->avail_in || z->avail_out == 0));
    return status == Z_STREAM_END;
}

/* All members, one after the other; what follows the last one is ignored, as gzip does. */
static int inflate_all(struct dx_slurp *s, const struct source *f, z_stream *z, uint8_t *piece)
{
    uint64_t read_len = 0;
    bool ended = false;

    for (;;) {
        ssize_t n = z->avail_in ? z->avail_in : read_some(f, piece, PIECE);
        int rc;

        if (n < 0)
            return (int)n;
        if (n == 0 && ended)
            return 0;
        if (n == 0)
            return dx_err_set(f->err, -EBADMSG, "%s: byte %llu: gzip data end early", f->path,
                              (unsigned long long)read_len);
        if (!z->avail_in) {
            read_len += (uint64_t)n;
            z->next_in = piece;
            z->avail_in = (uInt)n;
        }
        if (ended && *z->next_in != 0x1f)
            return 0;
        if (ended)
            inflateReset(z);
        rc = inflate_piece(s, f, z, read_len);
        if (rc < 0)
            return rc;
        ended = rc == 1;
    }
}

static int read_gzip(struct dx_slurp *s, const struct source *f)
{
    uint8_t *piece = malloc(PIECE);
    z_stream z = {0};
    int rc = -ENOMEM;

    if (piece && inflateInit2(&z, GZIP_WINDOW) == Z_OK) {
        rc = inflate_all(s, f, &z, piece);
        inflateEnd(&z);
    } else {
        dx_err_set(f->err, rc, "%s: no memory to inflate", f->path);
    }
    free(piece);
    return rc;
}

static int read_open(struct dx_slurp *s, const struct source *f)
{
    uint8_t magic[2] = {0, 0};
    struct stat st;
    int rc;

    if (fstat(f->fd, &st) != 0)
        return dx_err_set(f->err, -errno, "%s: %s", f->path, strerror(errno));
    if (pread(f->fd, magic, 2, 0) == 2 && magic[0] == 0x1f && magic[1] == 0x8b)
        rc = read_gzip(s, f);
    else if ((uintmax_t)st.st_size > f->max)
        rc = too_large(f);
    else
        rc = read_plain(s, f, (size_t)st.st_size + 1);
    return rc == 0 && s->len > f->max ? too_large(f) : rc;
}

int dx_slurp_file(struct dx_slurp *s, const char *path, size_t max, struct dx_err *err)
{
    struct source f = {.path = path, .max = max, .err = err};
    int rc;

    s->len = 0;
    f.fd = dx_open_regular(path, err);
    if (f.fd < 0)
        return f.fd;
    rc = read_open(s, &f);
    close(f.fd);
    if (rc)
        s->len = 0;
    return rc;
}

void dx_slurp_fini(struct dx_slurp *s)
{
    free(s->bytes);
    *s = (struct dx_slurp){0};
}
