/*
 * The one table of configuration keys. A new key is a row here and a field in its struct; the list
 * in dexeld.yaml(5) is printed from it (tests/unit/test_config.c compares them).
 */
#include "daemon/config_table.h"

#include "drivers/file/mcap_pack.h"

#include <stddef.h>
#include <syslog.h>

#define TOP(field)       offsetof(struct dx_config, field), sizeof(((struct dx_config *)0)->field)
#define STREAM(field)    STREAM_AT(field), sizeof(((struct dx_stream_config *)0)->field)
#define STREAM_AT(field) offsetof(struct dx_stream_config, field)

/* The largest whole number that every YAML and JSON reader holds exactly. */
#define EXACT 9007199254740991.0

static const struct dx_config_word log_levels[] = {
    {"error", LOG_ERR}, {"warning", LOG_WARNING}, {"notice", LOG_NOTICE},
    {"info", LOG_INFO}, {"debug", LOG_DEBUG},     {NULL, 0},
};
static const struct dx_config_word rates[] = {{"real", 1}, {"max", 0}, {NULL, 0}};
static const struct dx_config_word automatic[] = {{"auto", 0}, {NULL, 0}};
static const struct dx_config_word seams[] = {{"auto", -1}, {"on", 1}, {"off", 0}, {NULL, 0}};
static const struct dx_config_word depths[] = {{"0", 0}, {"8", 1}, {"16", 2}, {NULL, 0}};
static const struct dx_config_word file_depths[] = {
    {"auto", -1}, {"0", 0}, {"8", 1}, {"16", 2}, {NULL, 0}};
static const struct dx_config_word filters[] = {
    {"off", DX_FILTER_OFF}, {"mean", DX_FILTER_MEAN}, {"median3", DX_FILTER_MEDIAN3}, {NULL, 0}};
static const struct dx_config_word holds[] = {{"auto", -1}, {NULL, 0}};
static const struct dx_config_word diagonals[] = {
    {"fixed", DX_DIAG_FIXED}, {"short", DX_DIAG_SHORT}, {"bend", DX_DIAG_BEND}, {NULL, 0}};
static const struct dx_config_word mixed[] = {
    {"off", DX_MIXED_OFF}, {"axis", DX_MIXED_AXIS}, {"strict", DX_MIXED_STRICT}, {NULL, 0}};
static const struct dx_config_word compressions[] = {
    {"none", DX_MCAP_NONE}, {"lz4", DX_MCAP_LZ4}, {"zstd", DX_MCAP_ZSTD}, {NULL, 0}};
static const struct dx_config_word centre[] = {{"auto", (int)DX_LENS_CENTRE}, {NULL, 0}};
static const struct dx_config_word none[] = {{"none", 0}, {NULL, 0}};
static const struct dx_config_word middle[] = {{"auto", -1}, {NULL, 0}};
static const struct dx_config_word kinect_bits[] = {{"10", 10}, {"11", 11}, {NULL, 0}};
static const struct dx_config_word all_steps[] = {{"auto", -1}, {NULL, 0}};
static const struct dx_config_word intensities[] = {{"0", 0}, {"16", 2}, {NULL, 0}};
static const struct dx_config_word echoes[] = {{"one", DX_HOKUYO_ECHO_ONE},
                                               {"first", DX_HOKUYO_ECHO_FIRST},
                                               {"last", DX_HOKUYO_ECHO_LAST},
                                               {"strongest", DX_HOKUYO_ECHO_STRONGEST},
                                               {NULL, 0}};
static const struct dx_config_word directions[] = {{"ccw", 0}, {"cw", 1}, {NULL, 0}};
static const struct dx_config_word sweeps[] = {
    {"full", DX_STAGE_FULL}, {"half", DX_STAGE_HALF}, {"swing", DX_STAGE_SWING}, {NULL, 0}};
static const struct dx_config_word halves[] = {{"auto", DX_STAGE_HALVES_AUTO},
                                               {"front", DX_STAGE_HALVES_FRONT},
                                               {"both", DX_STAGE_HALVES_BOTH},
                                               {NULL, 0}};
static const struct dx_config_word several[] = {{"last", 0}, {"mean", 1}, {NULL, 0}};
static const struct dx_config_word stamps[] = {{"original", 0}, {"new", 1}, {NULL, 0}};
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
     .help = "Connections at once to the mesh socket; further ones are refused."},
    {"log_level", DX_CONFIG_CHOICE, TOP(log_level), .words = log_levels, .preset = "info",
     .help = "The least important messages that are logged."},
    {"streams", DX_CONFIG_STREAMS, TOP(streams), .min = 1, .max = DX_CONFIG_MAX_STREAMS,
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

    {"streams[].synthetic", DX_CONFIG_DRIVER, STREAM(source.synthetic),
     .help = "Driver: a simulated scanner in an analytic scene, the same bytes on every machine."},
    {"streams[].synthetic.scene", DX_CONFIG_CHOICE, STREAM(source.synthetic.scene.scene),
     .word = dx_scene_name, .preset = "hall",
     .help = "What the scanner sees."},
    {"streams[].synthetic.size", DX_CONFIG_SIZE, STREAM(source.synthetic.scene.width),
     STREAM_AT(source.synthetic.scene.height), .min = 8, .max = DX_PLANE_MAX_SIDE,
     .words = automatic, .preset = "auto",
     .help = "Size of a frame, columns by rows.\nauto: what suits the scene."},
    {"streams[].synthetic.noise", DX_CONFIG_NUMBERS, STREAM(source.synthetic.scene.sigma),
     .min = 0, .max = 1000, .preset = "0",
     .help = "Range noise in metres; [s0, s1, s2] as in mesh.sigma, or s0 alone."},
    {"streams[].synthetic.dropouts", DX_CONFIG_NUMBER, STREAM(source.synthetic.scene.dropout),
     .min = 0, .max = 1, .preset = "0",
     .help = "Share of the dexels that get no return."},
    {"streams[].synthetic.mixed", DX_CONFIG_NUMBER, STREAM(source.synthetic.scene.mixed),
     .min = 0, .max = 1, .preset = "0",
     .help = "Share of the dexels at range steps that are a mix of both sides."},
    {"streams[].synthetic.seed", DX_CONFIG_UINT, STREAM(source.synthetic.scene.seed),
     .min = 0, .max = EXACT, .preset = "1",
     .help = "Seed of noise, drop-outs and mixed dexels."},
    {"streams[].synthetic.fps", DX_CONFIG_NUMBER, STREAM(source.synthetic.fps),
     .min = 0.001, .max = 100000, .preset = "10",
     .help = "Frames in a second of simulated time."},
    {"streams[].synthetic.frames", DX_CONFIG_UINT, STREAM(source.synthetic.n_frames),
     .min = 0, .max = EXACT, .preset = "0",
     .help = "Frames until the stream ends.\n0: it does not."},
    {"streams[].synthetic.loop", DX_CONFIG_BOOL, STREAM(source.synthetic.loop), .preset = "no",
     .help = "After the last frame start again with the first."},
    {"streams[].synthetic.wait", DX_CONFIG_UINT, STREAM(wait), .min = 0, .max = 4096, .preset = "0",
     .help = "Start when so many have subscribed."},
    {"streams[].synthetic.rate", DX_CONFIG_NUMBER, STREAM(source.synthetic.rate),
     .min = 0.001, .max = 1000, .words = rates, .preset = "real",
     .help = "Speed: as simulated, as fast as possible, or so many times faster."},
    {"streams[].synthetic.parts", DX_CONFIG_UINT, STREAM(source.synthetic.part_cols),
     .min = 0, .max = DX_PLANE_MAX_SIDE, .preset = "0",
     .help = "Columns delivered at a time, as a slow scanner does.\n0: whole frames."},
    {"streams[].synthetic.unit", DX_CONFIG_NUMBER, STREAM(source.synthetic.scene.unit_m),
     .min = 1e-6, .max = 1, .preset = "0.001",
     .help = "Metres: the step in which ranges are counted."},
    {"streams[].synthetic.attribute", DX_CONFIG_CHOICE,
     STREAM(source.synthetic.scene.attr_bytes), .words = depths, .preset = "16",
     .help = "Bits of reflectance with each dexel."},

    {"streams[].file", DX_CONFIG_DRIVER, STREAM(source.file),
     .help = "Driver: a recording, replayed the way a device would deliver it."},
    {"streams[].file.path", DX_CONFIG_PATH, STREAM(source.file.path), .min = 1, .max = 4095,
     .required = true,
     .help = "A file, a directory, or a pattern such as /data/scan-*.pcd.\n"
             "Several files are the frames of a sequence, in the order of their names.\n"
             "Recordings of dexeld (MCAP) are decoded as their own configuration says; of the keys here,\n"
             "rate, loop, lossless and wait count for them."},
    {"streams[].file.topic", DX_CONFIG_PATH, STREAM(source.file.topic), .min = 0, .max = 1024,
     .preset = "",
     .help = "Of MCAP files of other programs: the topic of the clouds, sensor_msgs/msg/PointCloud2 with\n"
             "rows and columns.\nEmpty: the only one."},
    {"streams[].file.rate", DX_CONFIG_NUMBER, STREAM(source.file.rate),
     .min = 0.001, .max = 1000, .words = rates, .preset = "real",
     .help = "Speed: as recorded, as fast as possible, or so many times faster."},
    {"streams[].file.fps", DX_CONFIG_NUMBER, STREAM(source.file.fps),
     .min = 0.001, .max = 100000, .preset = "10",
     .help = "Frames a second where the files carry no time."},
    {"streams[].file.loop", DX_CONFIG_BOOL, STREAM(source.file.loop), .preset = "no",
     .help = "After the last frame start again with the first."},
    {"streams[].file.start", DX_CONFIG_NUMBER, STREAM(source.file.start_s), .min = 0, .max = 1e9,
     .preset = "0",
     .help = "Of recordings: seconds from the start of the recording where the replay begins."},
    {"streams[].file.end", DX_CONFIG_NUMBER, STREAM(source.file.end_s), .min = 0, .max = 1e9,
     .preset = "0",
     .help = "Of recordings: seconds from the start of the recording where the replay ends.\n"
             "0: with the recording."},
    {"streams[].file.stamps", DX_CONFIG_CHOICE, STREAM(source.file.restamp), .words = stamps,
     .preset = "original",
     .help = "Of recordings: the device stamps of frames; as they were recorded (of a device without a\n"
             "clock: when the service had its bytes then), or anew, as if the device spoke now."},
    {"streams[].file.lossless", DX_CONFIG_BOOL, STREAM(lossless), .preset = "no",
     .help = "Skip no frame, and let subscribers ask for every epoch.\nNeeds rate max."},
    {"streams[].file.wait", DX_CONFIG_UINT, STREAM(wait), .min = 0, .max = 4096, .preset = "0",
     .help = "Start when so many have subscribed."},
    {"streams[].file.unit", DX_CONFIG_NUMBER, STREAM(source.file.fit.unit_m),
     .min = 1e-6, .max = 1, .words = automatic, .preset = "auto",
     .help = "Metres: the step in which ranges are counted.\n"
             "auto: the finest of 1, 2, 5, 10 ... that holds the largest range in 16 bits."},
    {"streams[].file.seam", DX_CONFIG_CHOICE, STREAM(source.file.fit.seam), .words = seams,
     .preset = "auto",
     .help = "Whether the first column follows the last, as in a full turn.\nauto: from the data."},
    {"streams[].file.size", DX_CONFIG_SIZE, STREAM(source.file.thin.width),
     STREAM_AT(source.file.thin.height), .min = 2, .max = DX_PLANE_MAX_SIDE, .words = automatic,
     .preset = "auto",
     .help = "Size of the array that samples are thinned into, columns by rows over the scan's field\n"
             "of view.\nauto: the scan's own grid."},
    {"streams[].file.keep", DX_CONFIG_CHOICE, STREAM(source.file.thin.keep), .word = dx_keep_name,
     .preset = "centre",
     .help = "With size: the sample that a dexel keeps when several fall into it; the one nearest to\n"
             "its axis or to the scanner, the lower median, the mean, or the first."},
    {"streams[].file.exact", DX_CONFIG_BOOL, STREAM(source.file.exact), .preset = "no",
     .help = "Vertices are the file's own points bit for bit, not those of their dexels' axes: 12 bytes\n"
             "a dexel more, and subscribers by f32 alone.\nNeeds ingest.filter off and hold 0."},
    {"streams[].file.attribute", DX_CONFIG_CHOICE, STREAM(source.file.attr_bytes),
     .words = file_depths, .preset = "auto",
     .help = "Bits of intensity with each dexel.\nauto: what the files have."},

    {"streams[].v4l2", DX_CONFIG_DRIVER, STREAM(source.v4l2),
     .help = "Driver: a depth camera that the kernel knows (Video4Linux).\n"
             "Which one is told by serial, port or path; all that are given must agree.\n"
             "None given: the only one."},
    {"streams[].v4l2.serial", DX_CONFIG_NAME, STREAM(source.v4l2.serial), .min = 0, .max = 63,
     .preset = "", .help = "Serial number of the USB device."},
    {"streams[].v4l2.port", DX_CONFIG_NAME, STREAM(source.v4l2.port), .min = 0, .max = 31,
     .preset = "", .help = "USB port, such as 1-2.3: bus 1, port 2, port 3 of the hub there."},
    {"streams[].v4l2.path", DX_CONFIG_PATH, STREAM(source.v4l2.path), .min = 0, .max = 4095,
     .preset = "",
     .help = "The node, a link to it such as those in /dev/v4l/by-path, or the name of such a link."},
    {"streams[].v4l2.format", DX_CONFIG_CHOICE, STREAM(source.v4l2.format),
     .word = dx_v4l2_format_name, .preset = "auto",
     .help = "Pixel format.\nauto: Z16, else INZI; the others may as well hold no depth."},
    {"streams[].v4l2.size", DX_CONFIG_SIZE, STREAM(source.v4l2.width),
     STREAM_AT(source.v4l2.height), .min = 2, .max = DX_PLANE_MAX_SIDE, .words = automatic,
     .preset = "auto",
     .help = "Size of a frame, columns by rows, for which fx, fy, cx and cy hold.\n"
             "auto: as the camera has it."},
    {"streams[].v4l2.fps", DX_CONFIG_NUMBER, STREAM(source.v4l2.fps), .min = 0.01, .max = 10000,
     .words = automatic, .preset = "auto",
     .help = "Frames a second; the camera takes the nearest that it can.\nauto: as it has it."},
    {"streams[].v4l2.unit", DX_CONFIG_NUMBER, STREAM(source.v4l2.unit_m), .min = 1e-6, .max = 1,
     .preset = "0.001",
     .help = "Metres a code; with disparity, metres a step of the ranges made of it."},
    {"streams[].v4l2.disparity", DX_CONFIG_NUMBERS, STREAM(source.v4l2.disparity),
     STREAM_AT(source.v4l2.disparity_given), .min = -1e9, .max = 1e9, .words = none,
     .preset = "none",
     .help = "[k, d0]: a code means a depth of k / (d0 - code) metres.\nnone: codes are depths."},
    {"streams[].v4l2.invalid", DX_CONFIG_UINT, STREAM(source.v4l2.invalid), .min = 0,
     .max = 65535, .preset = "0",
     .help = "The code of a pixel without a return; 0 is one as well where codes are depths."},
    {"streams[].v4l2.min_depth", DX_CONFIG_NUMBER, STREAM(source.v4l2.min_m), .min = 0,
     .max = 65535, .preset = "0", .help = "Metres: nearer ones are no return."},
    {"streams[].v4l2.max_depth", DX_CONFIG_NUMBER, STREAM(source.v4l2.max_m), .min = 0,
     .max = 65535, .preset = "0", .help = "Metres: deeper ones are no return.\n0: all count."},
    {"streams[].v4l2.fx", DX_CONFIG_NUMBER, STREAM(source.v4l2.lens.fx), .min = 1, .max = 1e6,
     .required = true, .help = "Focal length in pixels, across the columns."},
    {"streams[].v4l2.fy", DX_CONFIG_NUMBER, STREAM(source.v4l2.lens.fy), .min = 1, .max = 1e6,
     .words = automatic, .preset = "auto", .help = "The same, across the rows.\nauto: fx."},
    {"streams[].v4l2.cx", DX_CONFIG_NUMBER, STREAM(source.v4l2.lens.cx), .min = -1e6, .max = 1e6,
     .words = centre, .preset = "auto",
     .help = "Column that the optical axis meets; the centre of the first is 0.\n"
             "auto: the middle of the image."},
    {"streams[].v4l2.cy", DX_CONFIG_NUMBER, STREAM(source.v4l2.lens.cy), .min = -1e6, .max = 1e6,
     .words = centre, .preset = "auto", .help = "Row that it meets.\nauto: the middle."},
    {"streams[].v4l2.k1", DX_CONFIG_NUMBER, STREAM(source.v4l2.lens.k1), .min = -1000, .max = 1000,
     .preset = "0",
     .help = "Distortion of the lens (Brown), as calibration tools print it: k1, k2, p1, p2, k3."},
    {"streams[].v4l2.k2", DX_CONFIG_NUMBER, STREAM(source.v4l2.lens.k2), .min = -1000, .max = 1000,
     .preset = "0", .help = "As k1."},
    {"streams[].v4l2.p1", DX_CONFIG_NUMBER, STREAM(source.v4l2.lens.p1), .min = -1000, .max = 1000,
     .preset = "0", .help = "As k1."},
    {"streams[].v4l2.p2", DX_CONFIG_NUMBER, STREAM(source.v4l2.lens.p2), .min = -1000, .max = 1000,
     .preset = "0", .help = "As k1."},
    {"streams[].v4l2.k3", DX_CONFIG_NUMBER, STREAM(source.v4l2.lens.k3), .min = -1000, .max = 1000,
     .preset = "0", .help = "As k1."},
    {"streams[].kinect", DX_CONFIG_DRIVER, STREAM(source.kinect),
     .help = "Driver: the depth camera of a Kinect for Xbox 360 or Kinect for Windows v1, over USB."},
    {"streams[].kinect.serial", DX_CONFIG_NAME, STREAM(source.kinect.serial), .min = 0, .max = 63,
     .preset = "",
     .help = "The serial number of the camera that is meant.\nEmpty: any."},
    {"streams[].kinect.port", DX_CONFIG_NAME, STREAM(source.kinect.port), .min = 0, .max = 31,
     .preset = "",
     .help = "The USB port that it is attached to, as the kernel counts: 1-2.3.\nEmpty: any."},
    {"streams[].kinect.bits", DX_CONFIG_CHOICE, STREAM(source.kinect.bits), .words = kinect_bits,
     .preset = "11",
     .help = "Bits of a disparity.\n10: a tenth less to send, and nothing behind 5.2 m."},
    {"streams[].kinect.near", DX_CONFIG_BOOL, STREAM(source.kinect.near), .preset = "no",
     .help = "Near mode, of Kinect for Windows alone."},
    {"streams[].kinect.max", DX_CONFIG_NUMBER, STREAM(source.kinect.max_m), .min = 0.1, .max = 65,
     .preset = "10",
     .help = "Metres: depths above are no return."},
    {"streams[].kinect.fx", DX_CONFIG_NUMBER, STREAM(source.kinect.fx), .min = 1, .max = 1e5,
     .words = automatic, .preset = "auto",
     .help = "Pixels: the focal length along a row, of a calibration.\nauto: what the camera says."},
    {"streams[].kinect.fy", DX_CONFIG_NUMBER, STREAM(source.kinect.fy), .min = 1, .max = 1e5,
     .words = automatic, .preset = "auto",
     .help = "Pixels: the focal length along a column.\nauto: as fx."},
    {"streams[].kinect.cx", DX_CONFIG_NUMBER, STREAM(source.kinect.cx), .min = 0, .max = 639,
     .words = middle, .preset = "auto",
     .help = "The column where the axis of the lens goes through; the first is 0.\nauto: the middle."},
    {"streams[].kinect.cy", DX_CONFIG_NUMBER, STREAM(source.kinect.cy), .min = 0, .max = 479,
     .words = middle, .preset = "auto",
     .help = "The row where it does.\nauto: the middle."},
    {"streams[].kinect.tick_hz", DX_CONFIG_NUMBER, STREAM(source.kinect.tick_hz), .min = 1e6,
     .max = 1e9, .words = automatic, .preset = "auto",
     .help = "Ticks a second of the camera's clock.\nauto: 60e6, and after some seconds as measured."},
    {"streams[].hokuyo", DX_CONFIG_DRIVER, STREAM(source.hokuyo),
     .help = "Driver: a line scanner that speaks SCIP 2 (Hokuyo URG, UTM, UST) on a turning stage.\n"
             "Without tty and tcp it is looked for on USB."},
    {"streams[].hokuyo.tty", DX_CONFIG_PATH, STREAM(source.hokuyo.tty), .min = 0, .max = 255,
     .preset = "",
     .help = "A tty, as /dev/ttyACM0 or a link to it in /dev/serial/by-path."},
    {"streams[].hokuyo.baud", DX_CONFIG_UINT, STREAM(source.hokuyo.baud), .min = 19200,
     .max = 500000, .preset = "115200",
     .help = "Speed of a tty that is a serial line; by USB it means nothing."},
    {"streams[].hokuyo.tcp", DX_CONFIG_PATH, STREAM(source.hokuyo.tcp), .min = 0, .max = 255,
     .preset = "",
     .help = "Address of a scanner on the network, with its port unless that is 10940."},
    {"streams[].hokuyo.port", DX_CONFIG_PATH, STREAM(source.hokuyo.port), .min = 0, .max = 31,
     .preset = "",
     .help = "The USB port, as 1-2.3.\nEmpty: the first scanner that is found."},
    {"streams[].hokuyo.serial", DX_CONFIG_PATH, STREAM(source.hokuyo.serial), .min = 0, .max = 31,
     .preset = "",
     .help = "The scanner's serial number, as it tells it itself; another is refused.\nEmpty: any."},
    {"streams[].hokuyo.echo", DX_CONFIG_CHOICE, STREAM(source.hokuyo.echo), .words = echoes,
     .preset = "one",
     .help = "Which return of a beam counts.\n"
             "one: the scanner's own choice.\n"
             "first, last, strongest: of up to three, by scanners that tell several (UTM-30LX-EW)."},
    {"streams[].hokuyo.attribute", DX_CONFIG_CHOICE, STREAM(source.hokuyo.attr_bytes),
     .words = intensities, .preset = "0",
     .help = "Bits of intensity with each dexel.\nNot all scanners tell it, and it doubles what they send."},
    {"streams[].hokuyo.first_step", DX_CONFIG_NUMBER, STREAM(source.hokuyo.first_step),
     .min = 0, .max = 9999, .words = all_steps, .preset = "auto",
     .help = "The first step of a scan.\nauto: the first that the scanner measures."},
    {"streams[].hokuyo.last_step", DX_CONFIG_NUMBER, STREAM(source.hokuyo.last_step),
     .min = 0, .max = 9999, .words = all_steps, .preset = "auto",
     .help = "The last step of a scan.\nauto: the last that the scanner measures."},
    {"streams[].hokuyo.cluster", DX_CONFIG_UINT, STREAM(source.hokuyo.cluster), .min = 1,
     .max = 99, .preset = "1",
     .help = "Neighbouring steps of which the scanner tells the nearest alone."},
    {"streams[].hokuyo.skip", DX_CONFIG_UINT, STREAM(source.hokuyo.skip), .min = 0, .max = 9,
     .preset = "0",
     .help = "Scans that are left out after each."},
    {"streams[].hokuyo.stage", DX_CONFIG_MAP, STREAM(source.hokuyo.stage),
     .help = "The stage that turns the scanner about a vertical axis, and how the scanner sits on it."},
    {"streams[].hokuyo.stage.rpm", DX_CONFIG_NUMBER, STREAM(source.hokuyo.stage.angle.rpm),
     .min = 0.0001, .max = 1000, .required = true,
     .help = "Turns in a minute, at even speed."},
    {"streams[].hokuyo.stage.start", DX_CONFIG_NUMBER, STREAM(source.hokuyo.stage.angle.start_deg),
     .min = -360, .max = 360, .preset = "0",
     .help = "Degrees: the stage's angle when the monotonic clock of the host is 0; of a swing, the end\n"
             "from which it goes."},
    {"streams[].hokuyo.stage.direction", DX_CONFIG_CHOICE,
     STREAM(source.hokuyo.stage.angle.clockwise), .words = directions, .preset = "ccw",
     .help = "Which way it turns, seen from above."},
    {"streams[].hokuyo.stage.sweep", DX_CONFIG_CHOICE, STREAM(source.hokuyo.stage.sweep),
     .words = sweeps, .preset = "full",
     .help = "What a frame is: a turn, half a turn, or a way from one end of a swing to the other."},
    {"streams[].hokuyo.stage.swing", DX_CONFIG_NUMBER, STREAM(source.hokuyo.stage.angle.swing_deg),
     .min = 0, .max = 360, .preset = "0",
     .help = "Degrees: a stage that goes so far and back, with sweep swing.\n0: it turns on and on."},
    {"streams[].hokuyo.stage.columns", DX_CONFIG_UINT, STREAM(source.hokuyo.stage.columns),
     .min = 0, .max = DX_PLANE_MAX_SIDE - 1, .preset = "0",
     .help = "Columns of a whole turn, an even number.\n"
             "0: as many as there are scans in a turn, twice the scanner's own steps at the most."},
    {"streams[].hokuyo.stage.halves", DX_CONFIG_CHOICE, STREAM(source.hokuyo.stage.halves),
     .words = halves, .preset = "auto",
     .help = "Each scan has two halves, before and behind the axis.\n"
             "front: that which looks forward.\n"
             "both: joined in one grid where the mount allows it, else as two layers.\n"
             "auto: both, unless in a full turn the front half sees all that the other does."},
    {"streams[].hokuyo.stage.offset", DX_CONFIG_NUMBERS, STREAM(source.hokuyo.stage.offset_m),
     .min = -10, .max = 10, .preset = "0",
     .help = "Metres: where the scanner's centre sits, [forward, left, up] from the axis, at angle 0."},
    {"streams[].hokuyo.stage.angles", DX_CONFIG_NUMBERS, STREAM(source.hokuyo.stage.angles_deg),
     .min = -360, .max = 360, .preset = "0",
     .help = "Degrees: how the scanner sits, [roll, pitch, yaw].\n"
             "0: its front looks forward and its scan plane stands upright, with the steps counted upwards.\n"
             "Pitch raises its front; [0, 90, 0] looks up."},
    {"streams[].hokuyo.stage.keep", DX_CONFIG_CHOICE, STREAM(source.hokuyo.stage.mean),
     .words = several, .preset = "last",
     .help = "Of several scans in a column: the last, or the mean of those that agree."},
    {"streams[].hokuyo.stage.exact", DX_CONFIG_BOOL, STREAM(source.hokuyo.stage.exact),
     .preset = "no",
     .help = "Vertices are the points at the stage's own angle, not at their columns' middles: 12 bytes a\n"
             "dexel more, and subscribers by f32 alone.\nNeeds ingest.filter off, hold 0 and keep last."},
    {.path = NULL},
};
/* clang-format on */
