/*
 * The one table of metrics. A new one is a member of the status, a row here, and a line in
 * docs/operations.md (tests/system/metrics.sh compares them). Names follow Prometheus' rules: base
 * units, and `dexeld_` before all, also before what other programs call process_...: node_exporter
 * refuses a file with metrics that it has itself.
 */
#include "daemon/metrics.h"

#include "core/wire/wire.h"
#include "daemon/lifecycle.h"

#include <stddef.h>

#define US 1e-6
#define NS 1e-9

static const char *stream_state(unsigned k)
{
    return k <= DX_STREAM_FAULTED ? dx_stream_state_name(k) : NULL;
}

static const char *device_state(unsigned k)
{
    return k <= DX_LIFE_GONE ? dx_life_state_name((enum dx_life_state)k) : NULL;
}

#define SERVICE(kind_) .kind = DX_METRIC_##kind_, .of = DX_METRIC_OF_SERVICE
#define STREAM(kind_)  .kind = DX_METRIC_##kind_, .of = DX_METRIC_OF_STREAMS
#define CLIENT(kind_)  .kind = DX_METRIC_##kind_, .of = DX_METRIC_OF_CLIENTS

/* clang-format off */
const struct dx_metric dx_metrics[] = {
    {"dexeld_build_info", SERVICE(INFO), "version",
     .help = "Which version of dexeld this is."},
    {"dexeld_time_seconds", SERVICE(GAUGE), "time_s", .unit = "seconds",
     .help = "Unix time when these metrics were taken."},
    {"dexeld_uptime_seconds", SERVICE(GAUGE), "uptime_s", .unit = "seconds",
     .help = "Time since the service started."},
    {"dexeld_cpu_seconds", SERVICE(COUNTER), "cpu_s", .unit = "seconds",
     .help = "Processor time of all threads."},
    {"dexeld_resident_memory_bytes", SERVICE(GAUGE), "rss_bytes", .unit = "bytes",
     .help = "Resident memory."},
    {"dexeld_open_fds", SERVICE(GAUGE), "fds",
     .help = "Open file descriptors."},
    {"dexeld_max_fds", SERVICE(GAUGE), "max_fds",
     .help = "File descriptors that may be open at once."},
    {"dexeld_connections", SERVICE(COUNTER), "connections",
     .help = "Connections to the mesh socket so far."},

    {"dexeld_stream_info", STREAM(INFO), "geometry,width,height",
     .help = "The stream's grid: model of geometry, columns and rows."},
    {"dexeld_stream_state", STREAM(STATE), "state", .word = stream_state,
     .help = "Whether the stream is in this state."},
    {"dexeld_stream_frames", STREAM(COUNTER), "frames",
     .help = "Whole frames meshed."},
    {"dexeld_stream_parts", STREAM(COUNTER), "parts",
     .help = "Parts of frames taken; a frame that comes whole is one."},
    {"dexeld_stream_epochs", STREAM(COUNTER), "epochs",
     .help = "Meshes published."},
    {"dexeld_stream_drops", STREAM(COUNTER), "drops.mailbox", .label = "cause", .value = "mailbox",
     .help = "What was lost before the mesh: frames skipped because newer ones came (mailbox), blocks that "
             "could not be decoded (corrupt), what the device lost (lost) and sent damaged (damaged)."},
    {"dexeld_stream_drops", STREAM(COUNTER), "drops.corrupt", .label = "cause", .value = "corrupt"},
    {"dexeld_stream_drops", STREAM(COUNTER), "device.lost", .label = "cause", .value = "lost"},
    {"dexeld_stream_drops", STREAM(COUNTER), "device.damaged", .label = "cause", .value = "damaged"},
    {"dexeld_stream_lag_seconds", STREAM(GAUGE), "lag_s", .unit = "seconds",
     .help = "Time since the data of the newest mesh were read."},
    {"dexeld_stream_valid_ratio", STREAM(GAUGE), "valid", .unit = "ratio",
     .help = "Share of the dexels that have a range."},
    {"dexeld_stream_mesh_dexel_seconds", STREAM(GAUGE), "mesh_ns_per_dexel", NS, .unit = "seconds",
     .help = "Time to compute the last mesh, over all dexels of the grid."},
    {"dexeld_stream_mesh_seconds", STREAM(COUNTER), "mesh_s", .unit = "seconds",
     .help = "Time spent computing meshes."},
    {"dexeld_stream_tiles_changed", STREAM(COUNTER), "tiles_changed",
     .help = "Tiles that changed, over all meshes."},
    {"dexeld_stream_tiles_suppressed", STREAM(COUNTER), "tiles_same",
     .help = "Tiles that did not change, over all meshes, and so were not sent."},
    {"dexeld_stream_tiles_sent", STREAM(COUNTER), "tiles_sent",
     .help = "Tiles sent, to all clients."},
    {"dexeld_stream_short_of_chunks", STREAM(COUNTER), "short_of_chunks",
     .help = "Meshes that waited because clients held the room for tiles."},
    {"dexeld_stream_clients", STREAM(GAUGE), "subscribers",
     .help = "Clients that subscribe to the stream now."},
    {"dexeld_stream_slow_clients", STREAM(COUNTER), "slow",
     .help = "Times that a client was too slow, lost its place and began anew."},
    {"dexeld_stream_thread_hangs", STREAM(GAUGE), "hangs.reader", .label = "thread", .value = "reader",
     .help = "Whether a thread of the stream hangs, or, of the recorder, waits for its disk."},
    {"dexeld_stream_thread_hangs", STREAM(GAUGE), "hangs.mesher", .label = "thread", .value = "mesher"},
    {"dexeld_stream_thread_hangs", STREAM(GAUGE), "hangs.recorder", .label = "thread",
     .value = "recorder"},
    {"dexeld_stream_latency_seconds", STREAM(HISTOGRAM), "latency_ms", .unit = "seconds",
     .help = "From a frame's arrival until the kernel had its mesh for a client."},
    {"dexeld_stream_stage_seconds", STREAM(HISTOGRAM), "latency_ms.stages.decode", .unit = "seconds",
     .label = "stage", .value = "decode",
     .help = "What each stage adds to the latency."},
    {"dexeld_stream_stage_seconds", STREAM(HISTOGRAM), "latency_ms.stages.wait",
     .label = "stage", .value = "wait"},
    {"dexeld_stream_stage_seconds", STREAM(HISTOGRAM), "latency_ms.stages.mesh",
     .label = "stage", .value = "mesh"},
    {"dexeld_stream_stage_seconds", STREAM(HISTOGRAM), "latency_ms.stages.encode",
     .label = "stage", .value = "encode"},
    {"dexeld_stream_stage_seconds", STREAM(HISTOGRAM), "latency_ms.stages.send",
     .label = "stage", .value = "send"},

    {"dexeld_device_info", STREAM(INFO), "device.serial,device.place",
     .help = "Which device the stream has, or had last."},
    {"dexeld_device_state", STREAM(STATE), "device.state", .word = device_state,
     .help = "Whether the device is in this state."},
    {"dexeld_device_state_duration_seconds", STREAM(GAUGE), "device.since_s", .unit = "seconds",
     .help = "Time that the device has been in its state."},
    {"dexeld_device_opens", STREAM(COUNTER), "device.opens",
     .help = "Times that the device was opened: each after the first is a reconnect."},
    {"dexeld_device_unplugged", STREAM(COUNTER), "device.unplugged",
     .help = "Times that the device went away."},
    {"dexeld_device_stalls", STREAM(COUNTER), "device.stalls",
     .help = "Times that the device fell silent."},
    {"dexeld_device_faults", STREAM(COUNTER), "device.faults",
     .help = "Times that the device failed."},
    {"dexeld_gpio_laser_on", STREAM(GAUGE), "device.gpio.laser",
     .help = "Whether the laser is enabled."},
    {"dexeld_gpio_interlock_open", STREAM(GAUGE), "device.gpio.interlock_open",
     .help = "Whether the interlock is open."},
    {"dexeld_gpio_interlock_openings", STREAM(COUNTER), "device.gpio.interlock_openings",
     .help = "Times that the interlock was opened."},
    {"dexeld_gpio_trigger_edges", STREAM(COUNTER), "device.gpio.trigger_edges",
     .help = "Edges of the trigger line."},
    {"dexeld_gpio_trigger_unpaired", STREAM(COUNTER), "device.gpio.trigger_unpaired",
     .help = "Frames and edges of the trigger that found no partner."},
    {"dexeld_gpio_pps_offset_seconds", STREAM(GAUGE), "device.gpio.pps_offset_us", US, .unit = "seconds",
     .help = "How far the clock is from the pulse a second."},

    {"dexeld_recording_started", STREAM(GAUGE), "recording.started",
     .help = "Whether the stream is to be recorded."},
    {"dexeld_recording_failing", STREAM(PRESENT), "recording.error_text",
     .help = "Whether the recording cannot be written now."},
    {"dexeld_recording_blocks", STREAM(COUNTER), "recording.blocks",
     .help = "Blocks taken to be written."},
    {"dexeld_recording_drops", STREAM(COUNTER), "recording.dropped",
     .help = "Blocks lost, for the disk was full or too slow."},
    {"dexeld_recording_written_bytes", STREAM(COUNTER), "recording.bytes", .unit = "bytes",
     .help = "Written to all files."},
    {"dexeld_recording_files", STREAM(COUNTER), "recording.files",
     .help = "Files begun."},
    {"dexeld_recording_waiting_bytes", STREAM(GAUGE), "recording.waiting", .unit = "bytes",
     .help = "In memory, not written yet."},
    {"dexeld_replay_position_seconds", STREAM(GAUGE), "replay.position_s", .unit = "seconds",
     .help = "Where the replay is, from the start of the recording."},
    {"dexeld_replay_paused", STREAM(GAUGE), "replay.paused",
     .help = "Whether the replay is paused."},

    {"dexeld_client_info", CLIENT(INFO), "uid,encoding,mode,lod,stride",
     .help = "What the client has asked for."},
    {"dexeld_client_sent_bytes", CLIENT(COUNTER), "bytes", .unit = "bytes",
     .help = "Bytes that the kernel took for the client."},
    {"dexeld_client_epochs", CLIENT(COUNTER), "epochs",
     .help = "Meshes sent to the client."},
    {"dexeld_client_coalesced", CLIENT(COUNTER), "coalesced",
     .help = "Meshes that the client did not get one by one, but with a later one."},
    {"dexeld_client_resets", CLIENT(COUNTER), "resets",
     .help = "Times that the client had to forget its mesh and begin anew."},
    {"dexeld_client_lag_seconds", CLIENT(GAUGE), "lag_s", .unit = "seconds",
     .help = "Time since there has been a newer mesh than the client has; 0 where there is none."},
    {.name = NULL},
};
/* clang-format on */
