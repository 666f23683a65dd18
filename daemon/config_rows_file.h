/* Rows of the table of keys: recordings and scans. Included by config_table.c alone, inside the
 * table. */

#define SEAMS_WORDS       WORDS({"auto", -1}, {"on", 1}, {"off", 0})
#define FILE_DEPTHS_WORDS WORDS({"auto", -1}, {"0", 0}, {"8", 1}, {"16", 2})
#define STAMPS_WORDS      WORDS({"original", 0}, {"new", 1})

/* clang-format off */
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
    {"streams[].file.stamps", DX_CONFIG_CHOICE, STREAM(source.file.restamp), .words = STAMPS_WORDS,
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
    {"streams[].file.seam", DX_CONFIG_CHOICE, STREAM(source.file.fit.seam), .words = SEAMS_WORDS,
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
     .words = FILE_DEPTHS_WORDS, .preset = "auto",
     .help = "Bits of intensity with each dexel.\nauto: what the files have."},
    /* clang-format on */
