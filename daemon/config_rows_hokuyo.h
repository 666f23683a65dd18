/* Rows of the table of keys: Hokuyo line scanners and their stage. Included by config_table.c
 * alone, inside the table. */

#define ALL_STEPS_WORDS WORDS({"auto", -1})
#define BAUDS_WORDS                                                                                \
    WORDS({"19200", 19200}, {"38400", 38400}, {"57600", 57600}, {"115200", 115200},                \
          {"230400", 230400}, {"500000", 500000})
#define INTENSITIES_WORDS WORDS({"0", 0}, {"16", 2})
#define ECHOES_WORDS                                                                               \
    WORDS({"one", DX_HOKUYO_ECHO_ONE}, {"first", DX_HOKUYO_ECHO_FIRST},                            \
          {"last", DX_HOKUYO_ECHO_LAST}, {"strongest", DX_HOKUYO_ECHO_STRONGEST})
#define DIRECTIONS_WORDS WORDS({"ccw", 0}, {"cw", 1})
#define SWEEPS_WORDS                                                                               \
    WORDS({"full", DX_STAGE_FULL}, {"half", DX_STAGE_HALF}, {"swing", DX_STAGE_SWING})
#define HALVES_WORDS                                                                               \
    WORDS({"auto", DX_STAGE_HALVES_AUTO}, {"front", DX_STAGE_HALVES_FRONT},                        \
          {"both", DX_STAGE_HALVES_BOTH})
#define SEVERAL_WORDS WORDS({"last", 0}, {"mean", 1})

/* clang-format off */
    {"streams[].hokuyo", DX_CONFIG_DRIVER, STREAM(source.hokuyo),
     .help = "Driver: a line scanner that speaks SCIP 2 (Hokuyo URG, UTM, UST) on a turning stage.\n"
             "Without tty and tcp it is looked for on USB."},
    {"streams[].hokuyo.tty", DX_CONFIG_PATH, STREAM(source.hokuyo.tty), .min = 0, .max = 255,
     .preset = "",
     .help = "A tty, as /dev/ttyACM0 or a link to it in /dev/serial/by-path."},
    {"streams[].hokuyo.baud", DX_CONFIG_CHOICE, STREAM(source.hokuyo.baud), .words = BAUDS_WORDS,
     .preset = "115200",
     .help = "Speed of a tty that is a serial line; by USB it means nothing."},
    {"streams[].hokuyo.tcp", DX_CONFIG_PATH, STREAM(source.hokuyo.tcp), .min = 0, .max = 255,
     .preset = "",
     .help = "Address of a scanner on the network, with its port unless that is 10940."},
    {"streams[].hokuyo.port", DX_CONFIG_PATH, STREAM(source.hokuyo.port), .min = 0, .max = 31,
     .preset = "",
     .help = "The USB port, as 1-2.3.\nEmpty: the first scanner that is found."},
    {"streams[].hokuyo.serial", DX_CONFIG_PATH, STREAM(source.hokuyo.serial), .min = 0, .max = 31,
     .preset = "",
     .help = "The scanner's serial number, as it tells it itself.\n"
             "Without tty, tcp and port those on USB are asked for it; at a place that is named another is a fault.\n"
             "Empty: any."},
    {"streams[].hokuyo.echo", DX_CONFIG_CHOICE, STREAM(source.hokuyo.echo), .words = ECHOES_WORDS,
     .preset = "one",
     .help = "Which return of a beam counts.\n"
             "one: the scanner's own choice.\n"
             "first, last, strongest: of up to three, by scanners that tell several (UTM-30LX-EW)."},
    {"streams[].hokuyo.attribute", DX_CONFIG_CHOICE, STREAM(source.hokuyo.attr_bytes),
     .words = INTENSITIES_WORDS, .preset = "0",
     .help = "Bits of intensity with each dexel.\nNot all scanners tell it, and it doubles what they send."},
    {"streams[].hokuyo.first_step", DX_CONFIG_NUMBER, STREAM(source.hokuyo.first_step),
     .min = 0, .max = 9999, .words = ALL_STEPS_WORDS, .preset = "auto",
     .help = "The first step of a scan.\nauto: the first that the scanner measures."},
    {"streams[].hokuyo.last_step", DX_CONFIG_NUMBER, STREAM(source.hokuyo.last_step),
     .min = 0, .max = 9999, .words = ALL_STEPS_WORDS, .preset = "auto",
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
     .min = 0, .max = 1000, .preset = "0",
     .help = "Turns in a minute, at even speed.\n"
             "With an encoder about so many, for the columns alone; 0: not known."},
    {"streams[].hokuyo.stage.start", DX_CONFIG_NUMBER, STREAM(source.hokuyo.stage.angle.start_deg),
     .min = -360, .max = 360, .preset = "0",
     .help = "Degrees: the stage's angle when the monotonic clock of the host is 0; of a swing, the end\n"
             "from which it goes."},
    {"streams[].hokuyo.stage.direction", DX_CONFIG_CHOICE,
     STREAM(source.hokuyo.stage.angle.clockwise), .words = DIRECTIONS_WORDS, .preset = "ccw",
     .help = "Which way it turns, seen from above."},
    {"streams[].hokuyo.stage.encoder", DX_CONFIG_MAP, STREAM(source.hokuyo.stage.angle.encoder),
     .help = "A quadrature encoder on GPIO lines that tells the stage's angle.\n"
             "A line is a chip and an offset, as gpiochip0:17, or the name that the board gives it."},
    {"streams[].hokuyo.stage.encoder.a", DX_CONFIG_PATH,
     STREAM(source.hokuyo.stage.angle.encoder.a), .min = 0, .max = 79, .preset = "none",
     .help = "Its line A.\nnone: there is no encoder."},
    {"streams[].hokuyo.stage.encoder.b", DX_CONFIG_PATH,
     STREAM(source.hokuyo.stage.angle.encoder.b), .min = 0, .max = 79, .preset = "none",
     .help = "Its line B."},
    {"streams[].hokuyo.stage.encoder.z", DX_CONFIG_PATH,
     STREAM(source.hokuyo.stage.angle.encoder.z), .min = 0, .max = 79, .preset = "none",
     .help = "Its index, high for a part of each turn of the encoder: the zero, and the proof that no\n"
             "edge was missed.\nnone: it has no index."},
    {"streams[].hokuyo.stage.encoder.counts", DX_CONFIG_UINT,
     STREAM(source.hokuyo.stage.angle.encoder.counts), .min = 4, .max = 16777216,
     .preset = "4096",
     .help = "Counts of one turn of the encoder: four times its lines."},
    {"streams[].hokuyo.stage.encoder.gear", DX_CONFIG_NUMBER,
     STREAM(source.hokuyo.stage.angle.encoder.gear), .min = 0.001, .max = 1000000,
     .preset = "1",
     .help = "Turns of the encoder for one of the stage."},
    {"streams[].hokuyo.stage.encoder.zero", DX_CONFIG_NUMBER,
     STREAM(source.hokuyo.stage.angle.encoder.zero_deg), .min = -360, .max = 360,
     .preset = "0",
     .help = "Degrees: the stage's angle at the index; without one, where it stands when it is opened."},
    {"streams[].hokuyo.stage.encoder.direction", DX_CONFIG_CHOICE,
     STREAM(source.hokuyo.stage.angle.encoder.reverse), .words = DIRECTIONS_WORDS,
     .preset = "ccw",
     .help = "Which way the stage turns, seen from above, when A rises before B."},
    {"streams[].hokuyo.stage.encoder.bias", DX_CONFIG_CHOICE,
     STREAM(source.hokuyo.stage.angle.encoder.bias), .words = biases,
     .preset = "as-is",
     .help = "The chip's own resistors."},
    {"streams[].hokuyo.stage.encoder.debounce_us", DX_CONFIG_UINT,
     STREAM(source.hokuyo.stage.angle.encoder.debounce_us), .min = 0, .max = 5000,
     .preset = "0",
     .help = "Microseconds that a level must last to count, where libgpiod 2 is.\n"
             "Less than a quarter of the shortest time from edge to edge."},
    {"streams[].hokuyo.stage.sweep", DX_CONFIG_CHOICE, STREAM(source.hokuyo.stage.sweep),
     .words = SWEEPS_WORDS, .preset = "full",
     .help = "What a frame is: a turn, half a turn, or a way from one end of a swing to the other."},
    {"streams[].hokuyo.stage.swing", DX_CONFIG_NUMBER, STREAM(source.hokuyo.stage.angle.swing_deg),
     .min = 0, .max = 360, .preset = "0",
     .help = "Degrees: a stage that goes so far and back, with sweep swing.\n0: it turns on and on."},
    {"streams[].hokuyo.stage.columns", DX_CONFIG_UINT, STREAM(source.hokuyo.stage.columns),
     .min = 0, .max = DX_PLANE_MAX_SIDE - 1, .preset = "0",
     .help = "Columns of a whole turn, an even number.\n"
             "0: as many as there are scans in a turn, twice the scanner's own steps at the most."},
    {"streams[].hokuyo.stage.halves", DX_CONFIG_CHOICE, STREAM(source.hokuyo.stage.halves),
     .words = HALVES_WORDS, .preset = "auto",
     .help = "Each scan has two halves, before and behind the axis.\n"
             "front: that which looks forward.\n"
             "both: joined in one grid where the mount allows it, else as two layers.\n"
             "auto: both, unless in a full turn the front half sees all that the other does."},
    {"streams[].hokuyo.stage.offset", DX_CONFIG_NUMBERS, STREAM(source.hokuyo.stage.offset_m),
     .min = -10, .max = 10, .three = true, .preset = "0",
     .help = "Metres: where the scanner's centre sits, [forward, left, up] from the axis, at angle 0."},
    {"streams[].hokuyo.stage.angles", DX_CONFIG_NUMBERS, STREAM(source.hokuyo.stage.angles_deg),
     .min = -360, .max = 360, .three = true, .preset = "0",
     .help = "Degrees: how the scanner sits, [roll, pitch, yaw].\n"
             "0: its front looks forward and its scan plane stands upright, with the steps counted upwards.\n"
             "Pitch raises its front; [0, 90, 0] looks up."},
    {"streams[].hokuyo.stage.keep", DX_CONFIG_CHOICE, STREAM(source.hokuyo.stage.mean),
     .words = SEVERAL_WORDS, .preset = "last",
     .help = "Of several scans in a column: the last, or the mean of those that agree."},
    {"streams[].hokuyo.stage.exact", DX_CONFIG_BOOL, STREAM(source.hokuyo.stage.exact),
     .preset = "no",
     .help = "Vertices are the points at the stage's own angle, not at their columns' middles: 12 bytes a\n"
             "dexel more, and subscribers by f32 alone.\nNeeds ingest.filter off, hold 0 and keep last."},
    /* clang-format on */
