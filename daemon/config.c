/*
 * The life of a configuration: made with defaults, read from a file or bytes, freed.
 */
#include "daemon/config_origin.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int dx_config_init(struct dx_config *config, uint32_t n)
{
    const struct dx_config_key *key;
    int r = 0;

    memset(config, 0, sizeof(*config));
    config->streams = calloc(n, sizeof(*config->streams));
    if (!config->streams)
        return -ENOMEM;
    for (key = dx_config_keys; key->path && !r; key++)
        if (!dx_config_key_in_stream(key))
            r = dx_config_value_preset(key, config);
    return r;
}

static void fini_stream(struct dx_stream_config *stream)
{
    const struct dx_config_key *key;

    for (key = dx_config_keys; key->path; key++)
        if (dx_config_key_applies(key, stream->driver ? stream->driver : ""))
            dx_config_value_free(key, stream);
}

void dx_config_fini(struct dx_config *config)
{
    const struct dx_config_key *key;

    for (uint32_t i = 0; i < config->n_streams; i++)
        fini_stream(&config->streams[i]);
    free(config->streams);
    for (key = dx_config_keys; key->path; key++)
        if (!dx_config_key_in_stream(key))
            dx_config_value_free(key, config);
    dx_config_origins_free(config->origins);
    memset(config, 0, sizeof(*config));
}

/* Reads to the end, or to one byte more than a configuration may have. */
static ssize_t read_all(int fd, char *bytes, size_t room)
{
    size_t len = 0;

    while (len < room) {
        ssize_t n = read(fd, bytes + len, room - len);

        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return -errno;
        if (n == 0)
            break;
        len += (size_t)n;
    }
    return (ssize_t)len;
}

/* size: auto is the scene's own; known only when the whole stream was read. */
static void settle_size(struct dx_stream_config *stream)
{
    struct dx_scene_config *scene = &stream->source.synthetic.scene, preset;

    if (strcmp(stream->driver, "synthetic") || scene->width)
        return;
    dx_scene_config_default(&preset, scene->scene);
    scene->width = preset.width;
    scene->height = preset.height;
}

static int keep_origins(struct dx_config *config, const struct dx_config_marks *marks,
                        const char *file, struct dx_err *err)
{
    int r = dx_config_origins_new(&config->origins, file, config->n_streams);

    if (r)
        return dx_err_set(err, r, "%.150s: %s", file, strerror(-r));
    dx_config_origins_take(config->origins, marks);
    return 0;
}

int dx_config_parse(struct dx_config *config, const char *file, const void *bytes, size_t len,
                    struct dx_err *err)
{
    struct dx_config_marks *marks;
    int r;

    memset(config, 0, sizeof(*config));
    if (len > DX_CONFIG_MAX_LEN)
        return dx_err_set(err, -EINVAL, "%.150s: found more than %u bytes, expected at most that",
                          file, DX_CONFIG_MAX_LEN);
    marks = calloc(1, sizeof(*marks));
    r = marks ? dx_config_init(config, DX_CONFIG_MAX_STREAMS) : -ENOMEM;
    if (r)
        dx_err_set(err, r, "%.150s: %s", file, strerror(-r));
    if (!r)
        r = dx_config_parse_yaml(config, marks, file, bytes, len, err);
    if (!r)
        r = dx_config_check(config, marks, file, err);
    if (!r)
        r = keep_origins(config, marks, file, err);
    for (uint32_t n = 0; n < config->n_streams && !r; n++)
        settle_size(&config->streams[n]);
    if (r)
        dx_config_fini(config);
    free(marks);
    return r;
}

int dx_config_load(struct dx_config *config, const char *path, struct dx_err *err)
{
    size_t room = DX_CONFIG_MAX_LEN + 1;
    char *bytes = NULL;
    ssize_t len;
    int fd, r;

    memset(config, 0, sizeof(*config));
    fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return dx_err_set(err, -errno, "%.150s: %s", path, strerror(errno));
    bytes = malloc(room);
    len = bytes ? read_all(fd, bytes, room) : -ENOMEM;
    if (len < 0)
        r = dx_err_set(err, (int)len, "%.150s: %s", path, strerror((int)-len));
    else
        r = dx_config_parse(config, path, bytes, (size_t)len, err);
    free(bytes);
    close(fd);
    return r;
}
