/*
 * The one table of configuration keys. A new key is a row here, or in config_rows_NAME.h those of
 * driver NAME, and a field in its struct; the list in dexeld.yaml(5) is printed from it
 * (tests/unit/test_config.c compares them).
 */
#include "daemon/config_table.h"

#include "drivers/file/mcap_pack.h"

#include <stddef.h>
#include <syslog.h>

#define TOP(field)       TOP_AT(field), sizeof(((struct dx_config *)0)->field)
#define TOP_AT(field)    offsetof(struct dx_config, field)
#define STREAM(field)    STREAM_AT(field), sizeof(((struct dx_stream_config *)0)->field)
#define STREAM_AT(field) offsetof(struct dx_stream_config, field)
/* clang-format off */
#define WORDS(...)       (const struct dx_config_word[]){__VA_ARGS__, {NULL, 0}}
/* clang-format on */

/* The largest whole number that every YAML and JSON reader holds exactly. */
#define EXACT 9007199254740991.0

static const struct dx_config_word log_levels[] = {
    {"error", LOG_ERR}, {"warning", LOG_WARNING}, {"notice", LOG_NOTICE},
    {"info", LOG_INFO}, {"debug", LOG_DEBUG},     {NULL, 0},
};
static const struct dx_config_word rates[] = {{"real", 1}, {"max", 0}, {NULL, 0}};
static const struct dx_config_word automatic[] = {{"auto", 0}, {NULL, 0}};
static const struct dx_config_word filters[] = {
    {"off", DX_FILTER_OFF}, {"mean", DX_FILTER_MEAN}, {"median3", DX_FILTER_MEDIAN3}, {NULL, 0}};
static const struct dx_config_word holds[] = {{"auto", -1}, {NULL, 0}};
static const struct dx_config_word diagonals[] = {
    {"fixed", DX_DIAG_FIXED}, {"short", DX_DIAG_SHORT}, {"bend", DX_DIAG_BEND}, {NULL, 0}};
static const struct dx_config_word mixed[] = {
    {"off", DX_MIXED_OFF}, {"axis", DX_MIXED_AXIS}, {"strict", DX_MIXED_STRICT}, {NULL, 0}};
static const struct dx_config_word compressions[] = {
    {"none", DX_MCAP_NONE}, {"lz4", DX_MCAP_LZ4}, {"zstd", DX_MCAP_ZSTD}, {NULL, 0}};
static const struct dx_config_word biases[] = {{"as-is", DX_GPIO_AS_IS},
                                               {"off", DX_GPIO_DISABLED},
                                               {"pull-up", DX_GPIO_PULL_UP},
                                               {"pull-down", DX_GPIO_PULL_DOWN},
                                               {NULL, 0}};
static const struct dx_config_word lengths[] = {{"0", 0}, {"1", 1}, {"2", 2}, {NULL, 0}};

/* clang-format off */
const struct dx_config_key dx_config_keys[] = {
    {"socket", DX_CONFIG_PATH, TOP(socket), .min = 1, .max = DX_CONFIG_MAX_SOCKET,
     .preset = "/run/dexeld/mesh.sock",
     .help = "The Unix socket where subscribers get meshes."},
    {"control_socket", DX_CONFIG_PATH, TOP(control_socket), .min = 1, .max = DX_CONFIG_MAX_SOCKET,
     .preset = "/run/dexeld/control.sock",
     .help = "The Unix socket where the service tells its status."},
    {"threads", DX_CONFIG_UINT, TOP(threads), .min = 0, .max = 256, .preset = "0",
     .help = "Threads that compute tiles, shared by all streams.\n0: one for each processor."},
    {"max_clients", DX_CONFIG_UINT, TOP(max_clients), .min = 1, .max = 4096, .preset = "256",
     .live = true,
     .help = "Connections at once to the mesh socket; further ones are refused."},
    {"max_clients_per_uid", DX_CONFIG_UINT, TOP(max_clients_per_uid), .min = 0, .max = 4096,
     .preset = "0", .live = true,
     .help = "Of these, connections of one user.\n0: no bound of its own."},
    {"client_memory_mib", DX_CONFIG_UINT, TOP(client_memory_mib), .min = 1, .max = 65536,
     .preset = "256", .live = true,
     .help = "MiB that all subscribers together may make the service hold, some 0.4 each; further ones are\n"
             "refused."},
    {"max_requests", DX_CONFIG_UINT, TOP(max_requests), .min = 1, .max = 100000, .preset = "100",
     .live = true,
     .help = "Requests a second on the control socket, of all its clients; further ones are refused."},
    {"log_level", DX_CONFIG_CHOICE, TOP(log_level), .words = log_levels, .preset = "info",
     .live = true,
     .help = "The least important messages that are logged."},
    {"metrics_file", DX_CONFIG_PATH, TOP(metrics_file), .min = 0, .max = 4000, .preset = "",
     .help = "A file that metrics are written to, for the textfile collector of node_exporter, which\n"
             "takes names that end in .prom.\nEmpty: none."},
    {"metrics_s", DX_CONFIG_UINT, TOP(metrics_s), .min = 1, .max = 3600, .preset = "15",
     .help = "Seconds: the metrics file is written anew so often."},
    {"streams", DX_CONFIG_STREAMS, TOP_AT(streams), .min = 1, .max = DX_CONFIG_MAX_STREAMS,
     .required = true,
     .help = "The sources.\nEach has a name and exactly one driver."},

    {"streams[].name", DX_CONFIG_NAME, STREAM(name), .min = 1, .max = 63, .required = true,
     .help = "What subscribers ask for; no two streams share one."},
    {"streams[].commit_ms", DX_CONFIG_UINT, STREAM(commit_ms), .min = 0, .max = 60000,
     .preset = "33",
     .help = "Milliseconds: while a frame arrives in parts, the mesh of what is there is published at\n"
             "most this often, and at the end of the frame."},

    {"streams[].ingest", DX_CONFIG_MAP, STREAM(mesh.ingest),
     .help = "What becomes of the samples of a dexel from frame to frame."},
    {"streams[].ingest.filter", DX_CONFIG_CHOICE, STREAM(mesh.ingest.filter), .words = filters,
     .preset = "off",
     .help = "off: the newest sample is taken.\n"
             "mean: the mean of those that agree within the noise; stray ones are left out, gaps bridged,\n"
             "and what moves is followed with the second frame.\n"
             "median3: the median of the last three."},
    {"streams[].ingest.frames", DX_CONFIG_UINT, STREAM(mesh.ingest.n_max), .min = 1, .max = 255,
     .preset = "16",
     .help = "Frames that a mean counts at most."},
    {"streams[].ingest.gap", DX_CONFIG_UINT, STREAM(mesh.ingest.n_gap), .min = 0, .max = 254,
     .preset = "2",
     .help = "Frames without a return that a mean bridges."},
    {"streams[].ingest.hold", DX_CONFIG_NUMBER, STREAM(mesh.ingest.hold), .min = 0, .max = 100,
     .words = holds, .preset = "auto",
     .help = "Sigmas: a tile is published anew when a dexel has departed so far from what is published.\n"
             "0: any difference is published.\nauto: 1.5 with a filter, else 0."},
    {"streams[].ingest.keyframe", DX_CONFIG_UINT, STREAM(mesh.ingest.keyframe), .min = 0,
     .max = 1000000, .preset = "0",
     .help = "Every so many frames all is published, whatever hold says.\n0: never."},

    {"streams[].mesh", DX_CONFIG_MAP, STREAM(mesh), .help = "Which neighbours are joined."},
    {"streams[].mesh.sigma", DX_CONFIG_NUMBERS, STREAM(mesh.sigma), STREAM_AT(mesh.sigma_given),
     .min = 0, .max = 1000, .words = automatic, .preset = "auto",
     .help = "Range noise, one standard deviation at range r in metres: s0 + s1 r + s2 r^2, written\n"
             "[s0, s1, s2].\nauto: estimated from the first frame, then kept."},
    {"streams[].mesh.tilt", DX_CONFIG_NUMBER, STREAM(mesh.tilt_deg), .min = 0, .max = 89,
     .preset = "78.69",
     .help = "Degrees: the steepest incidence of a surface that is joined."},
    {"streams[].mesh.cap", DX_CONFIG_NUMBER, STREAM(mesh.cap_m), .min = 0, .max = 1e6,
     .preset = "0",
     .help = "Metres: the longest edge.\n0: no limit."},
    {"streams[].mesh.diag", DX_CONFIG_CHOICE, STREAM(mesh.diag), .words = diagonals,
     .preset = "bend",
     .help = "The diagonal of a cell of four neighbours: always the same one, the one whose ends differ\n"
             "less in range, or the one along which the surface bends less."},
    {"streams[].mesh.rescue", DX_CONFIG_BOOL, STREAM(mesh.rescue), .preset = "yes",
     .help = "Keep planes that are steeper than tilt where they continue on both sides."},
    {"streams[].mesh.mixed", DX_CONFIG_CHOICE, STREAM(mesh.mixed), .words = mixed,
     .preset = "axis",
     .help = "Leave out samples that lie between two surfaces: those cut off from both neighbours of\n"
             "their row or of their column (axis), and those joined to few neighbours (strict)."},
    {"streams[].mesh.bridge", DX_CONFIG_CHOICE, STREAM(mesh.bridge), .words = lengths,
     .preset = "1",
     .help = "Missing dexels in a row over which a surface is continued."},
    {"streams[].mesh.caps", DX_CONFIG_BOOL, STREAM(mesh.caps), .preset = "no",
     .help = "Close the hole at each pole of a full turn by a fan."},
    {"streams[].mesh.normals", DX_CONFIG_BOOL, STREAM(mesh.normals), .preset = "no",
     .help = "Compute a normal for each vertex, for subscribers who ask for normals."},
    {"streams[].mesh.smooth", DX_CONFIG_BOOL, STREAM(mesh.smooth), .preset = "no",
     .help = "Smooth ranges along the beam, by what joined neighbours tell: less noise, but the vertices\n"
             "are no samples then, and subscribers are told so.\nNot with exact points."},
    {"streams[].mesh.paper", DX_CONFIG_BOOL, STREAM(mesh.paper), .preset = "no",
     .help = "The rule of Gopi and Krishnan (2002) alone: edges no longer than cap.\n"
             "Overrides tilt, rescue, mixed, bridge and diag."},
    {"streams[].mesh.noise_gate", DX_CONFIG_NUMBER, STREAM(mesh.noise_k), .min = 0, .max = 100,
     .preset = "4",
     .help = "Range steps below so many sigmas count as noise and are joined."},

#include "daemon/config_rows_gpio.h"

    {"streams[].record", DX_CONFIG_MAP, STREAM(record),
     .help = "Recordings of what the device said, as MCAP files that dexeld replays."},
    {"streams[].record.path", DX_CONFIG_PATH, STREAM(record.path), .min = 0, .max = 4000,
     .preset = "",
     .help = "The files' names: a path that ends in .mcap, with %Y %m %d %H %M %S %j %F %T for the time\n"
             "(UTC) in its last part.\nA name that exists gets _0002, _0003 and so on.\nEmpty: no recording."},
    {"streams[].record.start", DX_CONFIG_BOOL, STREAM(record.start), .preset = "yes",
     .help = "Record from the start of the service on.\nno: when dexel record start asks for it."},
    {"streams[].record.compression", DX_CONFIG_CHOICE, STREAM(record.compression),
     .words = compressions, .preset = "zstd",
     .help = "Of the chunks of a file."},
    {"streams[].record.split_mib", DX_CONFIG_UINT, STREAM(record.split_mib), .min = 0,
     .max = 1048576, .preset = "1024",
     .help = "MiB after which a file ends and the next begins; nothing between them is lost.\n0: any size."},
    {"streams[].record.split_s", DX_CONFIG_UINT, STREAM(record.split_s), .min = 0,
     .max = 31536000, .preset = "0",
     .help = "Seconds after which a file ends and the next begins.\n0: any time."},
    {"streams[].record.keep_mib", DX_CONFIG_UINT, STREAM(record.keep_mib), .min = 0,
     .max = 1073741824, .preset = "0",
     .help = "MiB of all files of this path that stay: the oldest are removed.\n"
             "At least twice split_mib.\n0: all stay."},
    {"streams[].record.buffer_mib", DX_CONFIG_UINT, STREAM(record.buffer_mib), .min = 1,
     .max = 4096, .preset = "64",
     .help = "MiB of memory for blocks on their way to the disk; what finds no room there is lost, and\n"
             "told.\nA block must fit into it whole."},

#include "daemon/config_rows_synthetic.h"
#include "daemon/config_rows_file.h"
#include "daemon/config_rows_v4l2.h"
#include "daemon/config_rows_hokuyo.h"
#include "daemon/config_rows_kinect.h"
    {.path = NULL},
};
/* clang-format on */
