/* Rows of the table of keys: the Kinect's depth camera. Included by config_table.c alone, inside
 * the table. */

#define MIDDLE_WORDS      WORDS({"auto", -1})
#define KINECT_BITS_WORDS WORDS({"10", 10}, {"11", 11})

/* clang-format off */
    {"streams[].kinect", DX_CONFIG_DRIVER, STREAM(source.kinect),
     .help = "Driver: the depth camera of a Kinect for Xbox 360 or Kinect for Windows v1, over USB."},
    {"streams[].kinect.serial", DX_CONFIG_NAME, STREAM(source.kinect.serial), .min = 0, .max = 63,
     .preset = "",
     .help = "The serial number of the camera that is meant.\nEmpty: any."},
    {"streams[].kinect.port", DX_CONFIG_NAME, STREAM(source.kinect.port), .min = 0, .max = 31,
     .preset = "",
     .help = "The USB port that it is attached to, as the kernel counts: 1-2.3.\nEmpty: any."},
    {"streams[].kinect.bits", DX_CONFIG_CHOICE, STREAM(source.kinect.bits), .words = KINECT_BITS_WORDS,
     .preset = "11",
     .help = "Bits of a disparity.\n10: a tenth less to send, and nothing behind 5.2 m."},
    {"streams[].kinect.near", DX_CONFIG_BOOL, STREAM(source.kinect.near), .preset = "no",
     .help = "Near mode, of Kinect for Windows alone."},
    {"streams[].kinect.max_depth", DX_CONFIG_NUMBER, STREAM(source.kinect.max_m), .min = 0.1, .max = 65,
     .preset = "10",
     .help = "Metres: depths above are no return."},
    {"streams[].kinect.fx", DX_CONFIG_NUMBER, STREAM(source.kinect.fx), .min = 1, .max = 1e5,
     .words = automatic, .preset = "auto",
     .help = "Pixels: the focal length along a row, of a calibration.\nauto: what the camera says."},
    {"streams[].kinect.fy", DX_CONFIG_NUMBER, STREAM(source.kinect.fy), .min = 1, .max = 1e5,
     .words = automatic, .preset = "auto",
     .help = "Pixels: the focal length along a column.\nauto: as fx."},
    {"streams[].kinect.cx", DX_CONFIG_NUMBER, STREAM(source.kinect.cx), .min = 0, .max = 639,
     .words = MIDDLE_WORDS, .preset = "auto",
     .help = "The column where the axis of the lens goes through; the first is 0.\nauto: the middle."},
    {"streams[].kinect.cy", DX_CONFIG_NUMBER, STREAM(source.kinect.cy), .min = 0, .max = 479,
     .words = MIDDLE_WORDS, .preset = "auto",
     .help = "The row where it does.\nauto: the middle."},
    {"streams[].kinect.tick_hz", DX_CONFIG_NUMBER, STREAM(source.kinect.tick_hz), .min = 1e6,
     .max = 1e9, .words = automatic, .preset = "auto",
     .help = "Ticks a second of the camera's clock.\nauto: 60e6, and after some seconds as measured."},
    /* clang-format on */
