/* record and replay, of the control socket. */
#include "daemon/control_stream.h"

#include "daemon/clock.h"
#include "daemon/player.h"
#include "daemon/recorder.h"
#include "daemon/server_priv.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define MAX_STEPS   1000000000
#define MAX_RATE    1000.0
#define MAX_SECONDS 1e9

static json_t *wrong(json_t *text)
{
    return json_pack("{s:o}", "error", text);
}

/* Which streams there are. */
static json_t *name_streams(const struct dx_server *server)
{
    char text[400] = "expected \"stream\", one of";
    size_t n = strlen(text);

    for (const struct dx_server_stream *st = server->streams; st && n < sizeof(text); st = st->next)
        n += (size_t)snprintf(text + n, sizeof(text) - n, "%s %s", st == server->streams ? "" : ",",
                              st->options.name);
    return json_string(text);
}

/* The stream that is meant: the named one, or the only one. NULL: *error says why. */
static struct dx_server_stream *find(struct dx_server *server, const json_t *request,
                                     json_t **error)
{
    const json_t *given = json_object_get(request, "stream");
    const char *name = json_string_value(given);
    struct dx_server_stream *st = server->streams;

    if (given && !name) {
        *error = wrong(json_string("\"stream\": expected a text"));
        return NULL;
    }
    if (!name && server->n_streams != 1) {
        *error = wrong(name_streams(server));
        return NULL;
    }
    while (st && name && strcmp(st->options.name, name))
        st = st->next;
    if (!st)
        *error = wrong(json_sprintf("no stream '%s'", name));
    return st;
}

static const char *what(const json_t *request)
{
    const char *text = json_string_value(json_object_get(request, "do"));

    return text ? text : "";
}

/* ---- record ----------------------------------------------------------------------------------
 */

/* For how long its disk has not answered. */
static double stuck_s(const struct dx_server_stream *st)
{
    const struct dx_heartbeat *beat = &st->options.beats->of[DX_BEAT_RECORDER];

    return (double)dx_heartbeat_late_ns(beat, dx_clock_ns()) * 1e-9;
}

json_t *dx_control_recording(const struct dx_server_stream *st)
{
    struct dx_recorder_status s;
    json_t *o;

    if (!st->options.recorder)
        return NULL;
    dx_recorder_status(st->options.recorder, &s);
    o = json_pack("{s:b,s:b,s:I,s:I,s:I,s:I,s:I}", "started", s.wanted, "writing", s.writing,
                  "blocks", (json_int_t)s.n_blocks, "dropped", (json_int_t)s.n_dropped, "bytes",
                  (json_int_t)s.n_bytes, "files", (json_int_t)s.n_files, "waiting",
                  (json_int_t)s.waiting);
    if (st->hangs[DX_BEAT_RECORDER])
        json_object_set_new(o, "stuck_s", json_real(stuck_s(st)));
    if (s.path[0])
        json_object_set_new(o, "path", json_string(s.path)); /* not UTF-8: stays out */
    if (s.error)
        json_object_set_new(o, "error_text", json_string(strerror(-s.error)));
    return o;
}

json_t *dx_control_record(struct dx_server *server, const json_t *request)
{
    json_t *error = NULL;
    struct dx_server_stream *st = find(server, request, &error);
    const char *verb = what(request);

    if (!st)
        return error;
    if (!st->options.recorder)
        return wrong(
            json_sprintf("stream '%s' has no record.path in the configuration", st->options.name));
    if (!strcmp(verb, "start"))
        dx_recorder_start_file(st->options.recorder);
    else if (!strcmp(verb, "stop"))
        dx_recorder_stop_file(st->options.recorder);
    else if (strcmp(verb, "status"))
        return wrong(json_string("\"do\": expected start, stop or status"));
    return dx_control_recording(st);
}

/* ---- replay ----------------------------------------------------------------------------------
 */

json_t *dx_control_replaying(const struct dx_server_stream *st)
{
    struct dx_player_status s;

    if (!st->options.player)
        return NULL;
    dx_player_status(st->options.player, &s);
    return json_pack("{s:b,s:b,s:o,s:f,s:f,s:I}", "paused", s.paused, "ended", s.ended, "rate",
                     s.rate > 0 ? json_real(s.rate) : json_string("max"), "position_s",
                     s.position_s, "length_s", s.length_s, "frames", (json_int_t)s.n_frames);
}

static json_t *seek(struct dx_device *player, const json_t *request)
{
    const json_t *v = json_object_get(request, "seconds");
    double seconds = json_number_value(v);

    if (!json_is_number(v) || !(seconds >= 0 && seconds <= MAX_SECONDS))
        return wrong(json_string("\"seconds\": expected a number from 0"));
    dx_player_seek(player, seconds);
    return NULL;
}

static json_t *set_rate(struct dx_device *player, const json_t *request)
{
    const json_t *v = json_object_get(request, "rate");
    const char *word = json_string_value(v);
    double rate = json_number_value(v);

    if (word && !strcmp(word, "max"))
        rate = 0;
    else if (word && !strcmp(word, "real"))
        rate = 1;
    else if (!json_is_number(v) || !(rate >= 0.001 && rate <= MAX_RATE))
        return wrong(json_string("\"rate\": expected real, max or a number from 0.001 to 1000"));
    dx_player_rate(player, rate);
    return NULL;
}

static json_t *step(struct dx_device *player, const json_t *request)
{
    const json_t *v = json_object_get(request, "frames");
    json_int_t n = v ? json_integer_value(v) : 1;

    if (n < 1 || n > MAX_STEPS)
        return wrong(json_string("\"frames\": expected a whole number from 1"));
    dx_player_step(player, (uint64_t)n);
    return NULL;
}

/* NULL: done; else what is wrong. */
static json_t *obey(struct dx_device *player, const json_t *request)
{
    const char *verb = what(request);
    struct dx_player_status s;

    dx_player_status(player, &s);
    if (s.ended && strcmp(verb, "status"))
        return wrong(json_string("the replay has ended, and so has its stream"));
    if (!strcmp(verb, "seek"))
        return seek(player, request);
    if (!strcmp(verb, "rate"))
        return set_rate(player, request);
    if (!strcmp(verb, "step"))
        return step(player, request);
    if (!strcmp(verb, "pause") || !strcmp(verb, "resume"))
        dx_player_pause(player, !strcmp(verb, "pause"));
    else if (strcmp(verb, "status"))
        return wrong(json_string("\"do\": expected pause, resume, seek, rate, step or status"));
    return NULL;
}

json_t *dx_control_replay(struct dx_server *server, const json_t *request)
{
    json_t *error = NULL;
    struct dx_server_stream *st = find(server, request, &error);

    if (!st)
        return error;
    if (!st->options.player)
        return wrong(json_sprintf("stream '%s' replays no recording", st->options.name));
    error = obey(st->options.player, request);
    return error ? error : dx_control_replaying(st);
}
