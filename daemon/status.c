/* The status of the service as JSON. Loop thread. */
#include "daemon/status.h"

#include <time.h>

#include "daemon/clock.h"
#include "daemon/control_stream.h"
#include "daemon/process.h"
#include "daemon/reader.h"
#include "daemon/server_priv.h"
#include "daemon/watchdog.h"

static void set_count(json_t *o, const char *key, uint64_t n)
{
    json_object_set_new(o, key, json_integer((json_int_t)n));
}

static void set_number(json_t *o, const char *key, double v)
{
    json_object_set_new(o, key, json_real(v));
}

static void set_text(json_t *o, const char *key, const char *text)
{
    json_object_set_new(o, key, json_string(text)); /* NULL (not UTF-8): stays out */
}

static double seconds_since(uint64_t ns)
{
    uint64_t now = dx_clock_ns();

    return now > ns ? (double)(now - ns) * 1e-9 : 0;
}

static void set_geometry(json_t *o, const struct dx_server_stream *st)
{
    const struct dx_feed_loop *l = st->loop;
    const struct dx_counters *c = st->options.counters;
    double n_dexels;

    if (!l->geometry)
        return;
    n_dexels = (double)l->geometry->height * l->geometry->width;
    set_text(o, "geometry", dx_model_name(l->geometry->model));
    set_count(o, "width", l->geometry->width);
    set_count(o, "height", l->geometry->height);
    json_object_set_new(
        o, "sigma",
        json_pack("[f,f,f]", l->params.sigma[0], l->params.sigma[1], l->params.sigma[2]));
    if (dx_get(&c->n_valid))
        set_number(o, "valid", (double)dx_get(&c->n_valid) / n_dexels);
    set_number(o, "mesh_ns_per_dexel", (double)dx_get(&c->mesh_ns_last) / n_dexels);
}

static json_t *spread(const struct dx_latency *h, bool histogram)
{
    json_t *o = json_object(), *within;

    if (h->n) {
        set_number(o, "p50", (double)dx_latency_quantile(h, 0.5) * 1e-6);
        set_number(o, "p99", (double)dx_latency_quantile(h, 0.99) * 1e-6);
    }
    if (!histogram)
        return o;
    within = json_array();
    for (int k = 0; k <= DX_LATENCY_BOUNDS; k++)
        json_array_append_new(within, json_integer((json_int_t)h->n_within[k]));
    set_number(o, "sum_s", (double)h->sum_ns * 1e-9);
    json_object_set_new(o, "within", within);
    return o;
}

static json_t *latency_status(const struct dx_server_stream *st, bool histograms)
{
    static const char *const names[DX_N_STAGES] = {"decode", "wait", "mesh", "encode", "send"};
    json_t *o = spread(&st->latency, histograms), *stages = json_object();

    for (int k = 0; k < DX_N_STAGES; k++)
        if (st->stage[k].n || histograms)
            json_object_set_new(stages, names[k], spread(&st->stage[k], histograms));
    json_object_set_new(o, "stages", stages);
    return o;
}

/* NULL: there are none. */
static json_t *lines_status(struct dx_rig *rig)
{
    struct dx_interlock_state interlock;
    struct dx_rig_status s;
    json_t *o;

    if (!rig)
        return NULL;
    dx_rig_tell(rig, &s);
    dx_interlock_is_open(dx_rig_interlock(rig), &interlock);
    o = json_object();
    json_object_set_new(o, "lines", json_boolean(s.has_lines));
    json_object_set_new(o, "laser", json_boolean(s.is_laser_on));
    json_object_set_new(o, "interlock_open", json_boolean(interlock.is_open));
    set_count(o, "interlock_openings", s.n_openings);
    set_count(o, "trigger_edges", s.n_edges);
    set_count(o, "trigger_pairs", s.n_pairs);
    set_count(o, "trigger_unpaired", s.n_unpaired);
    set_count(o, "trigger_resyncs", s.n_resyncs);
    set_count(o, "triggers_sent", s.n_triggers);
    if (!s.is_pps_locked)
        return o;
    set_number(o, "pps_offset_us", (double)s.pps_offset_ns * 1e-3);
    set_number(o, "pps_jitter_us", (double)s.pps_jitter_ns * 1e-3);
    set_number(o, "pps_rate_ppb", (double)s.pps_rate_ppb);
    return o;
}

/* NULL: the source is no device. */
static json_t *device_status(const struct dx_server_stream *st)
{
    struct dx_reader_device *d =
        st->options.reader ? dx_stream_reader_attached(st->options.reader) : NULL;
    struct dx_reader_device_status s;
    json_t *o;

    if (!d)
        return NULL;
    dx_reader_device_status(d, &s);
    o = json_object();
    set_text(o, "state", dx_life_state_name(s.state));
    set_number(o, "since_s", seconds_since(s.since_ns));
    if (*s.reason)
        set_text(o, "reason", s.reason);
    set_text(o, "serial", s.health.serial);
    set_text(o, "place", s.health.place);
    set_text(o, "trouble", s.health.trouble);
    set_count(o, "opens", s.n_opens);
    set_count(o, "lost", s.health.n_lost);
    set_count(o, "damaged", s.health.n_damaged);
    set_count(o, "stalls", s.n_stalls);
    set_count(o, "faults", s.n_faults);
    set_count(o, "unplugged", s.n_went);
    json_object_set_new(o, "gpio", lines_status(dx_reader_device_lines(d))); /* NULL: stays out */
    return o;
}

static void set_counters(json_t *o, const struct dx_server_stream *st)
{
    const struct dx_counters *c = st->options.counters;
    json_t *drops = json_object();

    set_count(o, "frames", dx_get(&c->n_frames));
    set_count(o, "parts", dx_get(&c->n_parts));
    set_number(o, "fps", st->frames_per_s);
    set_count(o, "epochs", dx_get(&c->n_epochs));
    set_count(o, "tiles_changed", dx_get(&c->n_tiles_changed));
    set_count(o, "tiles_same", dx_get(&c->n_tiles_same));
    set_count(o, "tiles_sent", dx_get(&c->n_tiles_sent));
    set_count(drops, "mailbox", st->loop->commit.n_dropped);
    set_count(drops, "corrupt", dx_get(&c->n_corrupt));
    json_object_set_new(o, "drops", drops);
    set_count(o, "short_of_chunks", dx_get(&c->n_short_of_chunks));
    set_number(o, "mesh_ms", (double)dx_get(&c->mesh_ns_last) * 1e-6);
    set_number(o, "mesh_s", (double)dx_get(&c->mesh_ns) * 1e-9);
    set_count(o, "subscribers", st->n_subscribers);
    set_count(o, "slow", dx_get(&c->n_slow));
}

/* As the watchdog found the stream's threads last. */
static json_t *hangs_status(const struct dx_server_stream *st)
{
    json_t *o = json_object();

    for (int k = 0; k < DX_N_BEATS; k++)
        json_object_set_new(o, dx_watchdog_thread((enum dx_beating)k), json_boolean(st->hangs[k]));
    return o;
}

static json_t *stream_status(const struct dx_server_stream *st, bool histograms)
{
    json_t *o = json_object();

    set_text(o, "name", st->options.name);
    set_text(o, "state", dx_stream_state_name(st->loop->state));
    set_text(o, "reason", st->loop->state_reason);
    set_geometry(o, st);
    set_counters(o, st);
    json_object_set_new(o, "hangs", hangs_status(st));
    if (st->newest_ns)
        set_number(o, "lag_s", seconds_since(st->newest_ns));
    if (st->latency.n || st->stage[DX_STAGE_DECODE].n || histograms)
        json_object_set_new(o, "latency_ms", latency_status(st, histograms));
    json_object_set_new(o, "device", device_status(st)); /* NULL: stays out; also the next */
    json_object_set_new(o, "recording", dx_control_recording(st));
    json_object_set_new(o, "replay", dx_control_replaying(st));
    return o;
}

json_t *dx_status_client(const struct dx_subscriber *s)
{
    json_t *o = json_object();

    set_count(o, "number", s->number);
    set_count(o, "pid", (uint64_t)s->cred.pid);
    set_count(o, "uid", s->cred.uid);
    if (s->stream) {
        set_text(o, "stream", s->stream->options.name);
        set_text(o, "encoding", dx_encoding_name(s->asked.encoding));
        set_text(o, "mode", dx_mode_name(s->asked.mode));
        set_number(o, "lod", (double)s->asked.lod.bound / DX_LOD_PER_SIGMA);
        set_count(o, "stride", s->asked.lod.stride);
    }
    set_count(o, "epochs", s->n_epochs);
    set_count(o, "coalesced", s->n_coalesced);
    set_count(o, "resets", s->n_resets);
    set_count(o, "bytes", s->n_bytes);
    if (s->stream)
        set_number(o, "lag_s", s->behind_ns ? seconds_since(s->behind_ns) : 0);
    return o;
}

static void set_process(json_t *o)
{
    struct dx_process p;
    struct timespec now;

    dx_process_look(&p);
    clock_gettime(CLOCK_REALTIME, &now);
    set_number(o, "time_s", (double)now.tv_sec + (double)now.tv_nsec * 1e-9);
    set_count(o, "rss_bytes", p.rss_bytes);
    set_number(o, "cpu_s", p.cpu_s);
    set_count(o, "fds", p.n_fds);
    if (p.max_fds)
        set_count(o, "max_fds", p.max_fds);
}

json_t *dx_status(const struct dx_server *server, bool histograms)
{
    json_t *o = json_object(), *streams = json_array(), *clients = json_array();

    set_text(o, "version", DEXELD_VERSION);
    set_number(o, "uptime_s", seconds_since(server->started_ns));
    set_process(o);
    set_count(o, "connections", server->n_connections);
    for (const struct dx_server_stream *st = server->streams; st; st = st->next)
        json_array_append_new(streams, stream_status(st, histograms));
    for (const struct dx_subscriber *s = server->subscribers; s; s = s->next)
        if (s->phase != DX_SUBSCRIBER_CLOSED)
            json_array_append_new(clients, dx_status_client(s));
    json_object_set_new(o, "streams", streams);
    json_object_set_new(o, "clients", clients);
    return o;
}
