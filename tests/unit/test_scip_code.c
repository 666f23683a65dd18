/* SCIP's numbers, check characters and lines: the published vectors (DEVICES.md 12). */
#include "drivers/hokuyo/scip_code.h"
#include "drivers/hokuyo/scip_scan.h"

#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

static uint32_t get(const char *text)
{
    return dx_scip_get((const uint8_t *)text, strlen(text));
}

static uint8_t sum(const char *text)
{
    return dx_scip_sum((const uint8_t *)text, strlen(text));
}

static void numbers(void **state)
{
    static const struct {
        const char *text;
        uint32_t value;
    } known[] = {{"CB", 1234},     {"1Dh", 5432}, {"m2@0", 16000000}, {"19?P", 300000},
                 {"0CB", 1234},    {"00D", 20},   {"000", 0},         {">YP", 60000},
                 {"0N90", 123456}, {"oo", 4095},  {"ooo", 262143},    {"oooo", 16777215}};
    uint8_t back[4];

    (void)state;
    for (size_t k = 0; k < sizeof(known) / sizeof(known[0]); k++) {
        assert_int_equal(get(known[k].text), known[k].value);
        dx_scip_put(back, strlen(known[k].text), known[k].value);
        assert_memory_equal(back, known[k].text, strlen(known[k].text));
    }
    assert_int_equal(get("0/0"), DX_SCIP_INVALID);
    assert_int_equal(get("0p0"), DX_SCIP_INVALID);
    assert_int_equal(get("0&0"), DX_SCIP_INVALID);
    assert_int_equal(dx_scip_get((const uint8_t *)"0\xff", 2), DX_SCIP_INVALID);
}

static void status_lines(void **state)
{
    static const char *const known[] = {"00P", "01Q", "02R", "03S", "04T", "05U", "06V",
                                        "07W", "08X", "0Aa", "0Bb", "0Cc", "0Dd", "0Ee",
                                        "0Ff", "0Ll", "10Q", "21S", "50U", "98a", "99b"};

    (void)state;
    for (size_t k = 0; k < sizeof(known) / sizeof(known[0]); k++) {
        const uint8_t *line = (const uint8_t *)known[k];
        uint8_t wrong[3] = {line[0], line[1], (uint8_t)(line[2] ^ 1)};

        assert_int_equal(dx_scip_status(line, 3), line[0] << 8 | line[1]);
        assert_int_equal(dx_scip_status(wrong, 3), 0);
        assert_int_equal(dx_scip_status(line, 2), 0);
    }
    assert_int_equal(sum("19?P"), 'i');
    assert_int_equal(sum("0N90"), 'W');
}

#define VV                                                                                         \
    "VEND:Hokuyo Automatic Co.,Ltd.;[\nPROD:SOKUIKI Sensor URG-04LX;[\n"                           \
    "FIRM:3.1.00(18/Jan./2007);`\nPROT:SCIP 2.0;N\nSERI:H0614967;V\n\n"
#define PP_URG                                                                                     \
    "MODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N\nDMIN:20;4\nDMAX:5600;_\nARES:1024;\\\n"           \
    "AMIN:44;7\nAMAX:725;o\nAFRT:384;6\nSCAN:600;e\n\n"
#define PP_UTM                                                                                     \
    "MODL:UTM-30LX(Hokuyo Automatic Co.,Ltd.);U\nDMIN:23;7\nDMAX:60000;J\nARES:1440;^\n"           \
    "AMIN:0;?\nAMAX:1080;Z\nAFRT:540;0\nSCAN:2400;U\n\n"

static struct dx_scip_cursor cursor(const char *text)
{
    return (struct dx_scip_cursor){(const uint8_t *)text, (const uint8_t *)text + strlen(text)};
}

static void what_it_tells(void **state)
{
    struct dx_scip_identity id;
    struct dx_scip_params p;
    char stat[64];

    (void)state;
    assert_true(dx_scip_read_identity(&id, cursor(VV)));
    assert_string_equal(id.serial, "H0614967");
    assert_true(dx_scip_read_params(&p, cursor(PP_URG)));
    assert_string_equal(p.model, "URG-04LX");
    assert_int_equal(p.class, DX_SCIP_CLASS_URG);
    assert_int_equal(p.ares, 1024);
    assert_int_equal(p.amin, 44);
    assert_int_equal(p.amax, 725);
    assert_int_equal(p.afrt, 384);
    assert_int_equal(p.dmin, 20);
    assert_int_equal(p.dmax, 5600);
    assert_int_equal(p.scan_rpm, 600);
    assert_true(dx_scip_read_params(&p, cursor(PP_UTM)));
    assert_int_equal(p.class, DX_SCIP_CLASS_UTM);
    assert_int_equal(p.scan_rpm, 2400);
    /* the semicolon summed as well, blanks, another order, unknown keys; a constant is missing */
    assert_true(dx_scip_sum_holds_key((const uint8_t *)"AMIN:44;2", 9));
    assert_int_equal(sum("AMIN:44;"), '2');
    assert_false(dx_scip_read_params(&p, cursor("DMIN:20;4\nDMAX:5600;_\n\n")));
    assert_false(dx_scip_read_params(&p, cursor("DMIN:20;5\n\n")));
    assert_true(dx_scip_read_trouble(stat, sizeof(stat),
                                     cursor("LASR:OFF;7\n"
                                            "STAT:Stable 000 no error.;f\n\n")));
    assert_string_equal(stat, "");
    assert_true(dx_scip_read_trouble(stat, sizeof(stat),
                                     cursor("MESM:000 Idle;J\n"
                                            "MESM:004 Multi_scan;_\n\n")));
}

/* ---- scans ------------------------------------------------------------------------------------
 */

static const struct dx_scip_params utm = {.ares = 1440,
                                          .amax = 1080,
                                          .afrt = 540,
                                          .dmin = 23,
                                          .dmax = 60000,
                                          .scan_rpm = 2400,
                                          .class = DX_SCIP_CLASS_UTM};

static int decode(const char *reply, uint32_t n, enum dx_scip_echo choice, uint32_t *mm,
                  uint8_t *reason, uint16_t *intensity)
{
    struct dx_scip_head head;
    struct dx_scip_format f;
    struct dx_err err;

    if (!dx_scip_scan_check(&head, (const uint8_t *)reply, strlen(reply)))
        return 1;
    assert_true(dx_scip_format_of(&f, (const uint8_t *)reply));
    return dx_scip_scan_decode(mm, reason, intensity, n, NULL, &utm, &f, choice, head.data, &err);
}

static void one_reply(void **state)
{
    static const char gd[] = "GD0538054201\n00P\n0N90W\n0CB1Dh00D000>YP]\n\n";
    struct dx_scip_head head;
    uint8_t reason[5];
    uint32_t mm[5];

    (void)state;
    assert_int_equal(decode(gd, 5, DX_SCIP_FIRST, mm, reason, NULL), 0);
    assert_true(dx_scip_scan_check(&head, (const uint8_t *)gd, strlen(gd)));
    assert_int_equal(head.stamp_ms, 123456);
    assert_int_equal(mm[0], 1234);
    assert_int_equal(mm[1], 5432);
    assert_int_equal(mm[2], 0); /* 20 mm: below DMIN, a reason */
    assert_int_equal(reason[2], 20);
    assert_int_equal(mm[3], 0);
    assert_int_equal(mm[4], 60000);
    assert_int_equal(decode(gd, 4, DX_SCIP_FIRST, mm, reason, NULL), -EBADMSG);
    assert_int_equal(decode(gd, 6, DX_SCIP_FIRST, mm, reason, NULL), -EBADMSG);
    assert_string_equal(dx_scip_reason_text(DX_SCIP_CLASS_UTM, 1), "no object");
}

/* Thirty values over two lines: one of them lies across the break. */
static void two_lines(void **state)
{
    static const char gd[] = "GD0000002901\n00P\n0N90W\n"
                             "0?X0?_0?f0?m0@40@;0@B0@I0@P0@W0@^0@e0@l0A30A:0AA0AH0AO0AV0A]0Ad0J\n"
                             "Ak0B20B90B@0BG0BN0BU0B\\0Bc@\n\n";
    uint32_t mm[30];
    char wrong[sizeof(gd)];

    (void)state;
    assert_int_equal(decode(gd, 30, DX_SCIP_FIRST, mm, NULL, NULL), 0);
    for (uint32_t k = 0; k < 30; k++)
        assert_int_equal(mm[k], 1000 + 7 * k);
    for (size_t k = strlen("GD0000002901\n"); k + 2 < sizeof(gd);
         k++) { /* any character but the echo's */
        memcpy(wrong, gd, sizeof(gd));
        wrong[k] = (char)(wrong[k] == '0' ? '1' : '0');
        assert_true(decode(wrong, 30, DX_SCIP_FIRST, mm, NULL, NULL) != 0);
    }
}

static void intensities_and_echoes(void **state)
{
    static const char ge[] = "GE0540054101\n00P\n0N90W\n0GL0b:0GM0cTj\n\n";
    static const char hd[] = "HD0540054101\n00P\n0N90W\n0GL&0Jh0GM?\n\n";
    /* 1500 mm at 3210, 1720 mm at 3300; then 1 (no object) and 1501 mm at 3210 */
    static const char he_data[] = "0GL0b:&0Jh0cT0010b:&0GM0b:";
    char he[80];
    uint16_t strength[2];
    uint32_t mm[2];

    (void)state;
    snprintf(he, sizeof(he), "HE0540054101\n00P\n0N90W\n%s%c\n\n", he_data, sum(he_data));
    assert_int_equal(decode(ge, 2, DX_SCIP_FIRST, mm, NULL, strength), 0);
    assert_int_equal(mm[0], 1500);
    assert_int_equal(strength[0], 3210);
    assert_int_equal(mm[1], 1501);
    assert_int_equal(strength[1], 3300);
    assert_int_equal(decode(hd, 2, DX_SCIP_FIRST, mm, NULL, NULL), 0);
    assert_int_equal(mm[0], 1500);
    assert_int_equal(mm[1], 1501);
    assert_int_equal(decode(hd, 2, DX_SCIP_LAST, mm, NULL, NULL), 0);
    assert_int_equal(mm[0], 1720);
    assert_int_equal(decode(he, 2, DX_SCIP_FIRST, mm, NULL, strength), 0);
    assert_int_equal(mm[0], 1500);
    assert_int_equal(mm[1], 1501); /* what is no return does not count while another is */
    assert_int_equal(decode(he, 2, DX_SCIP_STRONGEST, mm, NULL, strength), 0);
    assert_int_equal(mm[0], 1720);
    assert_int_equal(strength[0], 3300);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers),       cmocka_unit_test(status_lines),
        cmocka_unit_test(what_it_tells), cmocka_unit_test(one_reply),
        cmocka_unit_test(two_lines),     cmocka_unit_test(intensities_and_echoes),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
