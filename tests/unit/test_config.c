/*
 * The configuration: what a good file gives, the configuration of --replay, printing and reading
 * back, the shipped example, and the list of keys in dexeld.yaml(5). Errors are in
 * test_config_errors.c.
 *
 * `test_config keys` prints that list, to be put between the marks in docs/dexeld.yaml.5.
 */
#include "daemon/config.h"

#include <errno.h>
#include <locale.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <syslog.h>
#include <unistd.h>
#include <cmocka.h>

#define STREAM    "streams:\n  - name: a\n"
#define SYNTHETIC STREAM "    synthetic:\n"

static int parse(struct dx_config *config, const char *yaml, struct dx_err *err)
{
    return dx_config_parse(config, "t.yaml", yaml, strlen(yaml), err);
}

/* Parses what must be right. */
static void good(struct dx_config *config, const char *yaml)
{
    struct dx_err err = {""};

    if (parse(config, yaml, &err))
        fail_msg("%s", err.text);
}

static void test_defaults(void **state)
{
    struct dx_config c;
    struct dx_terrain_params mesh;
    struct dx_scene_config scene;
    const struct dx_synth_config *synth;

    (void)state;
    good(&c, SYNTHETIC);
    assert_string_equal(c.socket, "/run/dexeld/mesh.sock");
    assert_string_equal(c.control_socket, "/run/dexeld/control.sock");
    assert_int_equal(c.threads, 0);
    assert_int_equal(c.max_clients, 256);
    assert_int_equal(c.log_level, LOG_INFO);
    assert_int_equal(c.n_streams, 1);
    assert_string_equal(c.streams[0].name, "a");
    assert_string_equal(c.streams[0].driver, "synthetic");
    assert_int_equal(c.streams[0].commit_ms, 33);
    assert_int_equal(c.streams[0].line, 2);
    assert_int_equal(c.streams[0].wait, 0);
    assert_false(c.streams[0].lossless);

    dx_terrain_params_default(&mesh);
    assert_true(c.streams[0].mesh.tilt_deg == mesh.tilt_deg);
    assert_true(c.streams[0].mesh.noise_k == mesh.noise_k);
    assert_true(c.streams[0].mesh.cap_m == mesh.cap_m);
    assert_int_equal(c.streams[0].mesh.diag, mesh.diag);
    assert_int_equal(c.streams[0].mesh.paper, mesh.paper);
    assert_int_equal(c.streams[0].mesh.sigma_given, mesh.sigma_given);
    assert_int_equal(c.streams[0].mesh.ingest.filter, mesh.ingest.filter);
    assert_int_equal(c.streams[0].mesh.ingest.n_max, mesh.ingest.n_max);
    assert_int_equal(c.streams[0].mesh.ingest.n_gap, mesh.ingest.n_gap);
    assert_true(c.streams[0].mesh.ingest.hold == mesh.ingest.hold);
    assert_int_equal(c.streams[0].mesh.ingest.keyframe, mesh.ingest.keyframe);

    synth = &c.streams[0].source.synthetic;
    dx_scene_config_default(&scene, DX_SCENE_HALL);
    assert_int_equal(synth->scene.scene, DX_SCENE_HALL);
    assert_int_equal(synth->scene.width, scene.width);
    assert_int_equal(synth->scene.height, scene.height);
    assert_true(synth->scene.sigma[0] == 0 && synth->scene.dropout == 0);
    assert_int_equal(synth->scene.seed, 1);
    assert_true(synth->scene.unit_m == 0.001);
    assert_int_equal(synth->scene.attr_bytes, 2);
    assert_true(synth->fps == 10 && synth->rate == 1);
    assert_true(synth->n_frames == 0 && !synth->loop && synth->part_cols == 0);
    dx_config_fini(&c);
}

static void test_synthetic(void **state)
{
    struct dx_config c;
    const struct dx_stream_config *s;

    (void)state;
    good(&c, "socket: \"/tmp/m \\u00fc\"\n"
             "control_socket: /tmp/c\nmetrics_file: /m/x.prom\nmetrics_s: 5\n"
             "threads: 2\nmax_clients: 4096\nmax_clients_per_uid: 8\nlog_level: debug\n"
             "streams:\n"
             "  - name: hall-1.x_\n"
             "    commit_ms: 5\n"
             "    mesh: {sigma: [0.002, 1e-3], tilt: 60, cap: .5, diag: fixed, paper: yes,\n"
             "           noise_gate: 2}\n"
             "    synthetic: {size: 640x480, scene: moving-box, noise: 0.5, dropouts: 0.25,\n"
             "      mixed: 1, seed: 9007199254740991, fps: 2.5, frames: 7, loop: true, rate: max,\n"
             "      parts: 16, unit: 0.0005, attribute: 8}\n");
    s = &c.streams[0];
    assert_string_equal(c.socket, "/tmp/m \xc3\xbc");
    assert_string_equal(c.control_socket, "/tmp/c");
    assert_int_equal(c.threads, 2);
    assert_true(c.max_clients == 4096 && c.max_clients_per_uid == 8);
    assert_int_equal(c.log_level, LOG_DEBUG);
    assert_true(!strcmp(c.metrics_file, "/m/x.prom") && c.metrics_s == 5);
    assert_string_equal(s->name, "hall-1.x_");
    assert_int_equal(s->commit_ms, 5);
    assert_true(s->mesh.sigma_given);
    assert_true(s->mesh.sigma[0] == 0.002 && s->mesh.sigma[1] == 1e-3 && s->mesh.sigma[2] == 0);
    assert_true(s->mesh.tilt_deg == 60 && s->mesh.cap_m == 0.5 && s->mesh.noise_k == 2);
    assert_int_equal(s->mesh.diag, DX_DIAG_FIXED);
    assert_true(s->mesh.paper);
    assert_int_equal(s->source.synthetic.scene.scene, DX_SCENE_MOVING_BOX);
    assert_int_equal(s->source.synthetic.scene.width, 640);
    assert_int_equal(s->source.synthetic.scene.height, 480);
    assert_true(s->source.synthetic.scene.sigma[0] == 0.5);
    assert_true(s->source.synthetic.scene.sigma[1] == 0);
    assert_true(s->source.synthetic.scene.dropout == 0.25);
    assert_true(s->source.synthetic.scene.mixed == 1);
    assert_true(s->source.synthetic.scene.seed == 9007199254740991u);
    assert_true(s->source.synthetic.scene.unit_m == 0.0005);
    assert_int_equal(s->source.synthetic.scene.attr_bytes, 1);
    assert_true(s->source.synthetic.fps == 2.5 && s->source.synthetic.rate == 0);
    assert_true(s->source.synthetic.n_frames == 7 && s->source.synthetic.loop);
    assert_int_equal(s->source.synthetic.part_cols, 16);
    dx_config_fini(&c);
}

static void test_ingest(void **state)
{
    struct dx_config c;
    const struct dx_ingest_params *p;

    (void)state;
    good(&c,
         SYNTHETIC "    ingest: {filter: median3, hold: 2.5, frames: 255, gap: 0, keyframe: 9}\n"
                   "  - name: b\n    synthetic:\n    ingest: {filter: mean, hold: auto}\n"
                   "  - name: c\n    synthetic:\n    ingest: {hold: 0}\n");
    p = &c.streams[0].mesh.ingest;
    assert_int_equal(p->filter, DX_FILTER_MEDIAN3);
    assert_true(p->hold == 2.5);
    assert_true(p->n_max == 255 && p->n_gap == 0 && p->keyframe == 9);
    assert_int_equal(c.streams[1].mesh.ingest.filter, DX_FILTER_MEAN);
    assert_true(c.streams[1].mesh.ingest.hold < 0);
    assert_true(c.streams[2].mesh.ingest.hold == 0);
    dx_config_fini(&c);
}

static void test_file(void **state)
{
    struct dx_config c;
    const struct dx_file_config *f;

    (void)state;
    good(&c,
         "streams:\n"
         "- file: {path: /data/a b.ptx.gz}\n"
         "  name: one\n"
         "- name: two\n"
         "  file: {path: x, rate: max, fps: 30, loop: on, lossless: yes, wait: 2, unit: 0.002,\n"
         "         seam: off, attribute: 16, size: 1500x1000, keep: median}\n"
         "- name: three\n"
         "  mesh:\n"
         "  file: {path: x, rate: 2.5, seam: on, attribute: '0'}\n");
    assert_int_equal(c.n_streams, 3);
    f = &c.streams[0].source.file;
    assert_string_equal(c.streams[0].driver, "file");
    assert_string_equal(f->path, "/data/a b.ptx.gz");
    assert_true(f->rate == 1 && f->fps == 10 && !f->loop && f->attr_bytes == -1);
    assert_true(f->fit.unit_m == 0 && f->fit.seam == -1);
    assert_true(f->thin.width == 0 && f->thin.height == 0 && f->thin.keep == DX_KEEP_CENTRE);
    f = &c.streams[1].source.file;
    assert_true(f->rate == 0 && f->fps == 30 && f->loop && f->attr_bytes == 2);
    assert_true(f->fit.unit_m == 0.002 && f->fit.seam == 0);
    assert_true(f->thin.width == 1500 && f->thin.height == 1000 && f->thin.keep == DX_KEEP_MEDIAN);
    assert_true(c.streams[1].lossless);
    assert_int_equal(c.streams[1].wait, 2);
    f = &c.streams[2].source.file;
    assert_true(f->rate == 2.5 && f->attr_bytes == 0 && f->fit.seam == 1);
    assert_int_equal(c.streams[2].line, 7);
    dx_config_fini(&c);
    good(&c, "\xef\xbb\xbf%YAML 1.2\n---\n" SYNTHETIC "...\n");
    dx_config_fini(&c);
}

static const char whole[] =
    "socket: /tmp/a\n"
    "streams:\n"
    "  - name: hall\n"
    "    synthetic: {scene: hall, size: 600x400, noise: [0.002, 0, 1e-4], rate: 2.5}\n"
    "    mesh:\n"
    "      sigma: [0.002]\n"
    "      tilt: 78.69\n"
    "  - name: \"scan\"\n"
    "    file:\n"
    "      path: '/data/\xc3\xa9.ptx'\n"
    "      loop: yes\n";

static void test_truncated(void **state)
{
    (void)state;
    for (size_t len = 0; len < sizeof(whole); len++) {
        char *bytes = malloc(len ? len : 1); /* so that a sanitizer sees a read past the end */
        struct dx_config c;
        struct dx_err err = {""};
        int r;

        assert_non_null(bytes);
        memcpy(bytes, whole, len);
        r = dx_config_parse(&c, "t.yaml", bytes, len, &err);
        assert_true(r == 0 || r == -EINVAL);
        assert_true(r == 0 || !strncmp(err.text, "t.yaml:", 7));
        dx_config_fini(&c);
        free(bytes);
    }
}

static char *printed(const struct dx_config *config)
{
    size_t room = 1 << 16;
    char *text = calloc(1, room);
    FILE *out = text ? fmemopen(text, room, "w") : NULL;

    assert_non_null(out);
    if (config)
        dx_config_print(out, config);
    else
        dx_config_print_keys(out);
    fclose(out);
    return text;
}

/* Characters that YAML would fold, refuse or drop when they stand as they are. */
/* A map in a map; and what is printed reads back as the same, as it must for a recording. */
static void test_hokuyo(void **state)
{
    static const char yaml[] =
        "streams:\n  - name: turret\n    hokuyo:\n      tcp: 192.168.0.10\n      echo: last\n"
        "      first_step: 100\n      stage: {rpm: 2.5, direction: cw, sweep: half, exact: yes,\n"
        "              offset: [0.1, 0, 0.25], angles: [0, 90, 0]}\n";
    const struct dx_hokuyo_config *h;
    struct dx_config c, again;
    char *text, *text_again;

    (void)state;
    good(&c, yaml);
    h = &c.streams[0].source.hokuyo;
    assert_string_equal(h->tcp, "192.168.0.10");
    assert_int_equal(h->echo, DX_HOKUYO_ECHO_LAST);
    assert_true(h->first_step == 100 && h->last_step == -1);
    assert_true(h->stage.angle.rpm == 2.5 && h->stage.angle.clockwise && h->stage.exact);
    assert_int_equal(h->stage.sweep, DX_STAGE_HALF);
    assert_true(h->stage.offset_m[0] == 0.1 && h->stage.offset_m[2] == 0.25);
    assert_true(h->stage.angles_deg[1] == 90 && h->stage.angles_deg[2] == 0);
    text = printed(&c);
    assert_non_null(strstr(text, "\n      stage:\n        rpm: 2.5\n"));
    good(&again, text);
    text_again = printed(&again);
    assert_string_equal(text, text_again);
    free(text);
    free(text_again);
    dx_config_fini(&c);
    dx_config_fini(&again);
}

static void test_print_escapes(void **state)
{
    struct dx_config c;
    char *text;

    (void)state;
    good(&c, "socket: \"/\\\"\\\\\\n\\x7f\\N\\L\\ufeff\\uffff\\u20ac\"\n" SYNTHETIC);
    text = printed(&c);
    dx_config_fini(&c);
    assert_non_null(strstr(text, "socket: \"/\\\"\\\\\\u000a\\u007f\\u0085\\u2028\\ufeff\\uffff"
                                 "\xe2\x82\xac\"\n"));
    good(&c, text);
    assert_string_equal(c.socket,
                        "/\"\\\n\x7f\xc2\x85\xe2\x80\xa8\xef\xbb\xbf\xef\xbf\xbf\xe2\x82\xac");
    dx_config_fini(&c);
    free(text);
}

static void test_print(void **state)
{
    static const char expected[] = "socket: \"/tmp/a\"\n"
                                   "control_socket: \"/run/dexeld/control.sock\"\n"
                                   "threads: 0\n"
                                   "max_clients: 256\nmax_clients_per_uid: 0\n"
                                   "client_memory_mib: 256\nmax_requests: 100\nlog_level: info\n"
                                   "metrics_file: \"\"\nmetrics_s: 15\n"
                                   "streams:\n"
                                   "  - name: \"hall\"\n"
                                   "    commit_ms: 33\n"
                                   "    ingest:\n"
                                   "      filter: off\n"
                                   "      frames: 16\n"
                                   "      gap: 2\n"
                                   "      hold: auto\n"
                                   "      keyframe: 0\n"
                                   "    mesh:\n"
                                   "      sigma: [0.002, 0, 0]\n"
                                   "      tilt: 78.69\n";
    struct dx_config c, again;
    char *text, *text_again;

    (void)state;
    good(&c, whole);
    text = printed(&c);
    text[strlen(expected)] = '\0';
    assert_string_equal(text, expected);
    free(text);
    text = printed(&c);
    good(&again, text);
    text_again = printed(&again);
    assert_string_equal(text, text_again);
    free(text);
    free(text_again);
    dx_config_fini(&c);
    dx_config_fini(&again);
}

/* A decimal comma must not reach numbers, read or printed. */
static void test_locale(void **state)
{
    struct dx_config c;
    char *text;

    (void)state;
    if (!setlocale(LC_ALL, "de_DE.UTF-8") && !setlocale(LC_ALL, "fr_FR.UTF-8"))
        skip();
    good(&c, whole);
    assert_true(c.streams[0].mesh.tilt_deg == 78.69);
    text = printed(&c);
    assert_non_null(strstr(text, "tilt: 78.69\n"));
    free(text);
    dx_config_fini(&c);
    setlocale(LC_ALL, "C");
}

static void test_load(void **state)
{
    char path[] = "/tmp/dexeld-config-XXXXXX", text[100];
    int fd = mkstemp(path);
    struct dx_config c;
    struct dx_err err;

    (void)state;
    assert_true(fd >= 0);
    assert_int_equal(write(fd, whole, sizeof(whole) - 1), sizeof(whole) - 1);
    assert_int_equal(dx_config_load(&c, path, &err), 0);
    assert_string_equal(c.streams[1].source.file.path, "/data/\xc3\xa9.ptx");
    dx_config_fini(&c);
    assert_int_equal(ftruncate(fd, DX_CONFIG_MAX_LEN + 1), 0);
    assert_int_equal(dx_config_load(&c, path, &err), -EINVAL);
    snprintf(text, sizeof(text), "%s: found more than 1048576 bytes, expected at most that", path);
    assert_string_equal(err.text, text);
    close(fd);
    unlink(path);
    assert_int_equal(dx_config_load(&c, path, &err), -ENOENT);
    snprintf(text, sizeof(text), "%s: No such file or directory", path);
    assert_string_equal(err.text, text);
    assert_int_equal(dx_config_load(&c, "/", &err), -EISDIR);
    assert_string_equal(err.text, "/: Is a directory");
}

static void test_replay(void **state)
{
    struct dx_config_replay replay = {.path = "a.ptx", .socket = "/tmp/s"};
    struct dx_config c;
    struct dx_err err;

    (void)state;
    assert_int_equal(dx_config_for_replay(&c, &replay, &err), 0);
    assert_string_equal(c.socket, "/tmp/s");
    assert_string_equal(c.control_socket, "/tmp/s.control");
    assert_int_equal(c.n_streams, 1);
    assert_string_equal(c.streams[0].name, "replay");
    assert_string_equal(c.streams[0].driver, "file");
    assert_string_equal(c.streams[0].source.file.path, "a.ptx");
    assert_true(c.streams[0].source.file.rate == 1 && c.streams[0].source.file.fps == 10);
    assert_true(c.streams[0].source.file.attr_bytes == -1);
    assert_true(c.streams[0].mesh.tilt_deg == 78.69);
    assert_int_equal(c.streams[0].commit_ms, 33);
    assert_false(c.streams[0].lossless || c.streams[0].source.file.loop);
    assert_int_equal(c.streams[0].wait, 0);
    dx_config_fini(&c);

    replay.rate = "max";
    replay.loop = true;
    assert_int_equal(dx_config_for_replay(&c, &replay, &err), 0);
    assert_true(c.streams[0].source.file.rate == 0 && c.streams[0].source.file.loop);
    assert_true(c.streams[0].lossless);
    assert_int_equal(c.streams[0].wait, 1);
    dx_config_fini(&c);

    replay.wait = "0";
    assert_int_equal(dx_config_for_replay(&c, &replay, &err), 0);
    assert_int_equal(c.streams[0].wait, 0);
    dx_config_fini(&c);
}

static char *read_file(const char *path)
{
    char *text = calloc(1, 1 << 16);
    FILE *in = fopen(path, "r");

    assert_non_null(text);
    if (!in)
        fail_msg("%s: %s (run from the root of the tree)", path, strerror(errno));
    assert_true(fread(text, 1, (1 << 16) - 1, in) > 0);
    fclose(in);
    return text;
}

static void test_man_page(void **state)
{
    static const char begin[] = ".\\\" keys: printed by `test_config keys`\n",
                      end[] = ".\\\" end of keys\n";
    char *page = read_file("docs/dexeld.yaml.5"), *keys = printed(NULL);
    char *from = strstr(page, begin), *to = strstr(page, end);

    (void)state;
    assert_true(from && to && from < to);
    *to = '\0';
    if (strcmp(from + strlen(begin), keys))
        fail_msg("docs/dexeld.yaml.5: between its marks, expected what `test_config keys` prints");
    free(page);
    free(keys);
}

/* Takes the comment sign from lines that show a key: `#key` and `#  key`; `# words` are left alone.
 */
static void uncomment(char *text)
{
    for (char *p = text; *p; p += strcspn(p, "\n"), p += *p == '\n') {
        char *sign = p + strspn(p, " ");
        bool prose = *sign == '#' && sign[1] == ' ' && sign[2] != ' ';

        if (*sign == '#' && !prose && sign[1] != '\n')
            memmove(sign, sign + 1, strlen(sign));
    }
}

/* The example works as shipped, and shows every key: with none commented out it works as well. */
static void test_example(void **state)
{
    char *text = read_file("config/dexeld.yaml"), *keys = printed(NULL), *shipped, *all;
    struct dx_config c;

    (void)state;
    good(&c, text);
    assert_int_equal(c.n_streams, 1);
    shipped = printed(&c);
    dx_config_fini(&c);
    uncomment(text);
    good(&c, text);
    assert_int_equal(c.n_streams, 5);
    all = printed(&c);
    dx_config_fini(&c);
    assert_true(!strncmp(shipped, all, strlen(shipped))); /* what is commented out is the default */
    for (char *key = strstr(keys, ".It Ic "); key; key = strstr(key + 1, ".It Ic ")) {
        char name[80], *last;

        assert_int_equal(sscanf(key, ".It Ic %70s", name), 1);
        last = strrchr(name, '.') ? strrchr(name, '.') + 1 : name;
        strcat(last, ":");
        if (!strstr(text, last))
            fail_msg("config/dexeld.yaml does not show %s", name);
    }
    free(text);
    free(keys);
    free(shipped);
    free(all);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_defaults),  cmocka_unit_test(test_synthetic),
        cmocka_unit_test(test_ingest),    cmocka_unit_test(test_file),
        cmocka_unit_test(test_truncated), cmocka_unit_test(test_print),
        cmocka_unit_test(test_hokuyo),    cmocka_unit_test(test_print_escapes),
        cmocka_unit_test(test_locale),    cmocka_unit_test(test_load),
        cmocka_unit_test(test_replay),    cmocka_unit_test(test_man_page),
        cmocka_unit_test(test_example),
    };

    if (argc == 2 && !strcmp(argv[1], "keys")) {
        dx_config_print_keys(stdout);
        return 0;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
