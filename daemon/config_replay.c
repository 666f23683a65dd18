/*
 * The configuration that `dexeld --replay` means: one stream of the file driver, the options set
 * through the table of keys so that they allow what the file allows.
 */
#include "daemon/config_origin.h"

#include "drivers/file/playlist.h"

#include <errno.h>
#include <string.h>

static void came_from(struct dx_config *config, const char *path, uint32_t from)
{
    const struct dx_config_key *key = dx_config_key_find(path);

    *dx_config_origin(config->origins, dx_config_key_in_stream(key) ? 1 : 0, key) = from;
}

/* Sets one key from the command line; errors name the option. */
static int set_option(struct dx_config *config, const char *path, const char *option,
                      const char *text, struct dx_err *err)
{
    const struct dx_config_key *key = dx_config_key_find(path);
    char allowed[DX_CONFIG_ALLOWED_LEN], found[DX_CONFIG_QUOTE_LEN];
    void *base = dx_config_key_in_stream(key) ? (void *)config->streams : (void *)config;
    int r = dx_config_value_set(key, base, text);

    came_from(config, path, DX_CONFIG_FROM_OPTION);
    if (!r)
        return 0;
    if (r != -EINVAL)
        return dx_err_set(err, r, "%s", strerror(-r));
    dx_config_value_allowed(key, allowed);
    dx_config_quote(found, text);
    return dx_err_set(err, r, "%s: found %s, expected %s", option, found, allowed);
}

static int set_sockets(struct dx_config *config, const char *socket, struct dx_err *err)
{
    static const char suffix[] = ".control";
    char control[DX_CONFIG_MAX_SOCKET + 1];
    size_t len = strlen(socket), room = sizeof(control) - sizeof(suffix);
    char found[DX_CONFIG_QUOTE_LEN];
    int r;

    dx_config_quote(found, socket);
    if (!len || len > room)
        return dx_err_set(err, -EINVAL, "--socket: found %s, expected a path of 1 to %zu bytes",
                          found, room);
    memcpy(control, socket, len);
    memcpy(control + len, suffix, sizeof(suffix));
    r = set_option(config, "socket", "--socket", socket, err);
    return r ? r : set_option(config, "control_socket", "--socket", control, err);
}

/* The keys of what set_recorded() takes over. */
static void note_recorded(struct dx_config *config)
{
    const struct dx_config_key *mesh = dx_config_key_find("streams[].mesh"),
                               *ingest = dx_config_key_find("streams[].ingest"), *key;

    came_from(config, "streams[].commit_ms", DX_CONFIG_FROM_RECORDING);
    for (key = dx_config_keys; key->path; key++)
        if (dx_config_key_inside(key, mesh) || dx_config_key_inside(key, ingest))
            came_from(config, key->path, DX_CONFIG_FROM_RECORDING);
}

/* A recording is meshed as its stream was, unless its configuration cannot be read: the player will
 * say why. */
static void set_recorded(struct dx_config *config)
{
    struct dx_stream_config *stream = config->streams;
    struct dx_playlist *list;
    struct dx_config recorded;
    const char *text;
    size_t len;

    if (!dx_playlist_wants(stream->source.file.path) ||
        dx_playlist_new(&list, stream->source.file.path, NULL, NULL) != 0)
        return;
    text = dx_playlist_config(list, &len);
    if (dx_config_parse(&recorded, DX_RECORDING_CONFIG_NAME, text, len, NULL) == 0) {
        stream->mesh = recorded.streams[0].mesh;
        stream->commit_ms = recorded.streams[0].commit_ms;
        dx_config_fini(&recorded);
        note_recorded(config);
    }
    dx_playlist_free(list);
}

/* Those that are keys of the file driver, where they are given. */
static int set_file_options(struct dx_config *config, const struct dx_config_replay *replay,
                            struct dx_err *err)
{
    const struct dx_stream_config *stream = config->streams;
    const struct {
        const char *path, *option, *text;
    } given[] = {
        {"streams[].file.path", "--replay", replay->path},
        {"streams[].file.rate", "--rate", replay->rate},
        {"streams[].file.start", "--start", replay->start},
        {"streams[].file.end", "--end", replay->end},
        {"streams[].file.stamps", "--stamps", replay->stamps},
    };
    int r = 0;

    for (size_t k = 0; k < sizeof(given) / sizeof(given[0]) && !r; k++)
        if (given[k].text)
            r = set_option(config, given[k].path, given[k].option, given[k].text, err);
    if (!r && stream->source.file.end_s > 0 &&
        stream->source.file.end_s <= stream->source.file.start_s)
        r = dx_err_set(err, -EINVAL, "--end: expected more than --start, or 0");
    return r;
}

static int set_replay(struct dx_config *config, const struct dx_config_replay *replay,
                      struct dx_err *err)
{
    struct dx_stream_config *stream = config->streams;
    const struct dx_config_key *key;
    int r = 0;

    stream->driver = "file";
    for (key = dx_config_keys; key->path && !r; key++)
        if (dx_config_key_applies(key, stream->driver))
            r = dx_config_value_preset(key, stream);
    if (!r)
        r = set_option(config, "streams[].name", "--replay", "replay", err);
    if (!r)
        r = set_file_options(config, replay, err);
    if (r)
        return r;
    set_recorded(config);
    stream->source.file.loop = replay->loop;
    stream->lossless = stream->source.file.rate == 0;
    stream->wait = stream->lossless;
    if (replay->loop)
        came_from(config, "streams[].file.loop", DX_CONFIG_FROM_OPTION);
    if (stream->lossless) { /* rate max means these */
        came_from(config, "streams[].file.lossless", DX_CONFIG_FROM_OPTION);
        came_from(config, "streams[].file.wait", DX_CONFIG_FROM_OPTION);
    }
    return replay->wait ? set_option(config, "streams[].file.wait", "--wait", replay->wait, err)
                        : 0;
}

int dx_config_for_replay(struct dx_config *config, const struct dx_config_replay *replay,
                         struct dx_err *err)
{
    int r = dx_config_init(config, 1);

    if (!r)
        r = dx_config_origins_new(&config->origins, "", 1);
    if (r)
        dx_err_set(err, r, "%s", strerror(-r));
    else
        r = set_sockets(config, replay->socket, err);
    if (!r) {
        config->n_streams = 1;
        r = set_replay(config, replay, err);
    }
    if (!r && config->streams[0].wait > config->max_clients)
        r = dx_err_set(err, -EINVAL, "--wait: found %u, expected at most %u (connections at once)",
                       config->streams[0].wait, config->max_clients);
    if (r)
        dx_config_fini(config);
    return r;
}
