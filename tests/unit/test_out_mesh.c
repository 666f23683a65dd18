/* The bytes of small files in each format, and that a failed write leaves nothing behind. */
#include "core/base/bytes.h"
#include "tools/out_file.h"
#include "tools/out_mesh.h"

#include <dirent.h>
#include <errno.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cmocka.h>

static char folder[64];

static int make_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/dexel-test-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    char command[128];

    (void)state;
    snprintf(command, sizeof(command), "rm -rf %s", folder);
    return system(command);
}

static const char *path_of(const char *name)
{
    static char path[128];

    snprintf(path, sizeof(path), "%s/%s", folder, name);
    return path;
}

static size_t n_files(void)
{
    DIR *d = opendir(folder);
    size_t n = 0;

    assert_non_null(d);
    for (struct dirent *e = readdir(d); e; e = readdir(d))
        n += e->d_name[0] != '.';
    closedir(d);
    return n;
}

static size_t slurp(uint8_t *bytes, size_t max, const char *name)
{
    FILE *f = fopen(path_of(name), "rb");
    size_t len;

    assert_non_null(f);
    len = fread(bytes, 1, max, f);
    fclose(f);
    return len;
}

static const float corners[] = {0, 0, 0, 1, 0, 0, 0, 0.5f, 0};
static const uint16_t attrs[] = {0, 100, 200};

static struct dx_mesh triangle(uint8_t attr_bytes)
{
    struct dx_mesh m;

    assert_int_equal(dx_mesh_init(&m, 3, 1, attr_bytes, 0), 0);
    memcpy(m.xyz, corners, sizeof(corners));
    memcpy(m.index, (uint32_t[]){0, 1, 2}, 12);
    if (attr_bytes)
        memcpy(m.attr, attrs, sizeof(attrs));
    return m;
}

static void write_ok(const char *name, uint8_t attr_bytes, struct dx_out_options o)
{
    struct dx_mesh m = triangle(attr_bytes);
    struct dx_err err;

    if (dx_out_mesh(path_of(name), &m, &o, &err) != 0)
        fail_msg("%s", err.text);
    dx_mesh_fini(&m);
}

static void assert_text(const char *name, const char *expected)
{
    uint8_t bytes[1024];
    size_t len = slurp(bytes, sizeof(bytes) - 1, name);

    bytes[len] = 0;
    assert_string_equal((char *)bytes, expected);
}

/* 90 degrees about z, then 1000 along x. */
static const struct dx_out_options world = {.world = true,
                                            .pose = {0, -1, 0, 1000, 1, 0, 0, 0, 0, 0, 1, 0.25}};

static void test_ply_text(void **state)
{
    (void)state;
    write_ok("a.ply", 2, (struct dx_out_options){.ascii = true});
    assert_text("a.ply", "ply\nformat ascii 1.0\n"
                         "comment dexel " DEXELD_VERSION ", metres, scanner frame\n"
                         "element vertex 3\nproperty float x\nproperty float y\n"
                         "property float z\nproperty ushort intensity\nproperty uchar red\n"
                         "property uchar green\nproperty uchar blue\nelement face 1\n"
                         "property list uchar int vertex_indices\nend_header\n"
                         "0 0 0 0 0 0 0\n1 0 0 100 128 128 128\n0 0.5 0 200 255 255 255\n"
                         "3 0 1 2\n");
}

/* The normal goes with the pose: turned, not moved. */
static void test_normals(void **state)
{
    static const float normals[] = {1, 0, 0, 0, 1, 0, 0, 0, -1};
    struct dx_out_options o = world;
    struct dx_mesh m = triangle(1);
    uint8_t bytes[1024];
    struct dx_err err;
    size_t len;

    (void)state;
    assert_int_equal(dx_mesh_add_normals(&m), 0);
    memcpy(m.normal, normals, sizeof(normals));
    o.ascii = true;
    assert_int_equal(dx_out_mesh(path_of("n.ply"), &m, &o, &err), 0);
    assert_text("n.ply", "ply\nformat ascii 1.0\n"
                         "comment dexel " DEXELD_VERSION ", metres, world frame\n"
                         "element vertex 3\nproperty double x\nproperty double y\n"
                         "property double z\nproperty float nx\nproperty float ny\n"
                         "property float nz\nproperty uchar intensity\nproperty uchar red\n"
                         "property uchar green\nproperty uchar blue\nelement face 1\n"
                         "property list uchar int vertex_indices\nend_header\n"
                         "1000 0 0.25 0 1 0 0 0 0 0\n1000 1 0.25 -1 0 0 100 100 100 100\n"
                         "999.5 0 0.25 0 0 -1 200 200 200 200\n3 0 1 2\n");
    assert_int_equal(dx_out_mesh(path_of("n.obj"), &m, &(struct dx_out_options){0}, &err), 0);
    assert_text("n.obj", "# dexel " DEXELD_VERSION ", metres, scanner frame\n"
                         "v 0 0 0\nv 1 0 0\nv 0 0.5 0\n"
                         "vn 1 0 0\nvn 0 1 0\nvn 0 0 -1\nf 1//1 2//2 3//3\n");
    assert_int_equal(dx_out_mesh(path_of("n2.ply"), &m, &(struct dx_out_options){0}, &err), 0);
    len = slurp(bytes, sizeof(bytes), "n2.ply");
    assert_true(len > 13 + 3 * 28);
    assert_int_equal(dx_get_u32(bytes + len - 13 - 8), 0xbf800000); /* nz of the last: -1 */
    dx_mesh_fini(&m);
}

static void test_ply_binary(void **state)
{
    static const uint8_t body[] = {
        0, 0, 0,    0,    0, 0, 0, 0,    0, 0, 0, 0, 0,   0,   0,   0,   /* */
        0, 0, 0x80, 0x3f, 0, 0, 0, 0,    0, 0, 0, 0, 100, 100, 100, 100, /* */
        0, 0, 0,    0,    0, 0, 0, 0x3f, 0, 0, 0, 0, 200, 200, 200, 200, /* */
        3, 0, 0,    0,    0, 1, 0, 0,    0, 2, 0, 0, 0};
    uint8_t bytes[1024];
    size_t len;

    (void)state;
    write_ok("b.ply", 1, (struct dx_out_options){0});
    len = slurp(bytes, sizeof(bytes), "b.ply");
    assert_true(len > sizeof(body));
    assert_memory_equal(bytes, "ply\nformat binary_little_endian 1.0\n", 36);
    assert_memory_equal(bytes + len - sizeof(body) - 11, "end_header\n", 11);
    assert_memory_equal(bytes + len - sizeof(body), body, sizeof(body));
}

static void test_ply_world_is_double(void **state)
{
    uint8_t bytes[1024];
    double p[9];
    size_t len;

    (void)state;
    write_ok("w.ply", 0, world);
    len = slurp(bytes, sizeof(bytes), "w.ply");
    bytes[len] = 0;
    assert_non_null(strstr((char *)bytes, "property double x\n"));
    memcpy(p, bytes + len - 13 - sizeof(p), sizeof(p)); /* tests run on little-endian machines */
    assert_true(p[0] == 1000 && p[1] == 0 && p[2] == 0.25);
    assert_true(p[3] == 1000 && p[4] == 1 && p[6] == 999.5);
}

static void test_obj(void **state)
{
    (void)state;
    write_ok("a.obj", 1, (struct dx_out_options){0});
    assert_text("a.obj", "# dexel " DEXELD_VERSION ", metres, scanner frame\n"
                         "v 0 0 0\nv 1 0 0\nv 0 0.5 0\nf 1 2 3\n");
}

static void test_stl(void **state)
{
    uint8_t bytes[256];
    float f[12];

    (void)state;
    write_ok("a.stl", 1, (struct dx_out_options){0});
    assert_int_equal(slurp(bytes, sizeof(bytes), "a.stl"), 134);
    assert_memory_not_equal(bytes, "solid", 5);
    assert_memory_equal(bytes + 80, "\1\0\0\0", 4);
    memcpy(f, bytes + 84, sizeof(f));
    assert_memory_equal(f, ((float[]){0, 0, 1}), 12);
    assert_memory_equal(f + 3, corners, sizeof(corners));
    assert_memory_equal(bytes + 132, "\0\0", 2);
}

static void test_extension(void **state)
{
    struct dx_err err;

    (void)state;
    assert_non_null(dx_mesh_writer_for("x/y.PLY", &err));
    assert_null(dx_mesh_writer_for("x.ply/y", &err));
    assert_null(dx_mesh_writer_for("y.glb", &err));
    assert_string_equal(err.text, "y.glb: found extension '.glb', expected .ply, .obj or .stl");
}

static void test_replaces_whole_files_and_keeps_links(void **state)
{
    struct stat st;
    char target[128];

    (void)state;
    write_ok("t.obj", 0, (struct dx_out_options){0});
    strcpy(target, path_of("t.obj"));
    assert_int_equal(symlink(target, path_of("l.obj")), 0);
    write_ok("l.obj", 0, (struct dx_out_options){.ascii = true});
    assert_int_equal(lstat(path_of("l.obj"), &st), 0);
    assert_true(S_ISLNK(st.st_mode));
}

static void test_full_disk_leaves_the_old_file(void **state)
{
    struct rlimit was, low;
    struct dx_mesh m;
    struct dx_err err;
    size_t before;
    int rc;

    (void)state;
    write_ok("f.ply", 0, (struct dx_out_options){.ascii = true});
    before = n_files();
    assert_int_equal(dx_mesh_init(&m, 100000, 0, 0, 0), 0);
    memset(m.xyz, 0, 1200000);
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &was), 0);
    low = was;
    low.rlim_cur = 65536;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &low), 0);
    rc = dx_out_mesh(path_of("f.ply"), &m, &(struct dx_out_options){0}, &err);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &was), 0);
    dx_mesh_fini(&m);
    assert_int_equal(rc, -EFBIG);
    assert_non_null(strstr(err.text, "f.ply: cannot be written: "));
    assert_int_equal(n_files(), before);
    assert_text("f.ply", "ply\nformat ascii 1.0\ncomment dexel " DEXELD_VERSION
                         ", metres, scanner frame\nelement vertex 3\nproperty float x\n"
                         "property float y\nproperty float z\nelement face 1\n"
                         "property list uchar int vertex_indices\nend_header\n"
                         "0 0 0\n1 0 0\n0 0.5 0\n3 0 1 2\n");
}

static void test_devices_are_written_in_place(void **state)
{
    struct dx_out_file f;
    struct dx_err err;
    struct stat st;

    (void)state;
    assert_int_equal(dx_out_file_open(&f, "/dev/full", &err), 0);
    fputs("x", f.stream);
    assert_int_equal(dx_out_file_commit(&f, &err), -ENOSPC);
    assert_string_equal(err.text, "/dev/full: cannot be written: No space left on device");
    assert_int_equal(stat("/dev/full", &st), 0);
    assert_true(S_ISCHR(st.st_mode));
    assert_int_equal(dx_out_file_open(&f, "/nowhere/x.ply", &err), -ENOENT);
    assert_non_null(strstr(err.text, "/nowhere/x.ply: cannot be opened for writing"));
}

static void test_abort_leaves_nothing(void **state)
{
    struct dx_out_file f;
    struct dx_err err;
    size_t before = n_files();

    (void)state;
    assert_int_equal(dx_out_file_open(&f, path_of("gone.ply"), &err), 0);
    assert_int_equal(n_files(), before + 1);
    dx_out_file_abort(&f);
    assert_int_equal(n_files(), before);
    dx_out_file_abort(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ply_text),
        cmocka_unit_test(test_normals),
        cmocka_unit_test(test_ply_binary),
        cmocka_unit_test(test_ply_world_is_double),
        cmocka_unit_test(test_obj),
        cmocka_unit_test(test_stl),
        cmocka_unit_test(test_extension),
        cmocka_unit_test(test_replaces_whole_files_and_keeps_links),
        cmocka_unit_test(test_full_disk_leaves_the_old_file),
        cmocka_unit_test(test_devices_are_written_in_place),
        cmocka_unit_test(test_abort_leaves_nothing),
    };

    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
