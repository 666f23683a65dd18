/*
 * What a service may answer to the tools that ask on the control socket: none of them may fail at
 * it but with a text. A thread of ours is the service. The live screen of `dexel status` writes
 * nothing to the terminal but its own, whatever is in the answer.
 *
 * Input: a byte for the command, then the answer; of SCREEN two of them, a line each.
 */
#include "tools/cmd.h"
#include "tools/status_screen.h"

#include <errno.h>
#include <getopt.h>
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

#define MUST(condition)                                                                            \
    do {                                                                                           \
        if (!(condition))                                                                          \
            abort();                                                                               \
    } while (0)

static char dir[] = "/tmp/dexeld-fuzz-XXXXXX", path[64];

/* ---- the service ------------------------------------------------------------------------------
 */

static struct {
    pthread_mutex_t lock;
    uint8_t bytes[1 << 16];
    size_t len;
} answer = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* Until the end of a line, or of the connection. */
static void read_line(int fd)
{
    char byte;

    while (recv(fd, &byte, 1, 0) == 1 && byte != '\n')
        ;
}

static void *serve(void *listener)
{
    static uint8_t bytes[sizeof(answer.bytes)];
    int fd;

    while ((fd = accept(*(const int *)listener, NULL, NULL)) >= 0) {
        size_t len;

        read_line(fd);
        pthread_mutex_lock(&answer.lock);
        len = answer.len;
        memcpy(bytes, answer.bytes, len);
        pthread_mutex_unlock(&answer.lock);
        (void)!send(fd, bytes, len, MSG_NOSIGNAL);
        close(fd);
    }
    return NULL;
}

static void clean(void)
{
    unlink(path);
    rmdir(dir);
}

/* What the tools print is not for us. */
static void start(void)
{
    static int listener;
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    pthread_t thread;

    MUST(mkdtemp(dir));
    snprintf(path, sizeof(path), "%s/control", dir);
    strcpy(addr.sun_path, path);
    listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    MUST(bind(listener, (struct sockaddr *)&addr, sizeof(addr)) == 0);
    MUST(listen(listener, 16) == 0);
    MUST(pthread_create(&thread, NULL, serve, &listener) == 0);
    pthread_detach(thread);
    atexit(clean);
    setenv("DEXEL_DOCTOR_ROOT", dir, 1);
    stdout = stderr = fopen("/dev/null", "w");
    MUST(stdout);
}

/* ---- the commands -----------------------------------------------------------------------------
 */

#define MAX_WORDS 6

static const struct {
    int (*run)(int argc, char **argv);
    const char *words[MAX_WORDS];
} commands[] = {
    {cmd_status, {"status", "--socket", path}},
    {cmd_status, {"status", "--json", "--socket", path}},
    {cmd_clients, {"clients", "--socket", path}},
    {cmd_clients, {"clients", "--disconnect", "3", "--socket", path}},
    {cmd_devices, {"devices", "--socket", path}},
    {cmd_config, {"config", "--socket", path}},
    {cmd_reload, {"reload", "--socket", path}},
    {cmd_metrics, {"metrics", "--socket", path}},
    {cmd_record, {"record", "status", "--socket", path}},
    {cmd_replay, {"replay", "status", "--socket", path}},
    {cmd_log_level, {"log-level", "--socket", path}},
    {cmd_quit, {"quit", "--socket", path}},
    {cmd_doctor, {"doctor", "--socket", "/none", "--control", "/control"}},
};

#define SCREEN (sizeof(commands) / sizeof(*commands))

static void run(size_t k)
{
    char *argv[MAX_WORDS + 1] = {NULL};
    int argc = 0, status;

    while (argc < MAX_WORDS && commands[k].words[argc]) {
        argv[argc] = strdup(commands[k].words[argc]);
        argc++;
    }
    optind = 0; /* glibc's getopt begins anew */
    status = commands[k].run(argc, argv);
    MUST(status == 0 || status == 1);
    while (argc > 0)
        free(argv[--argc]);
}

/* ---- the screen -------------------------------------------------------------------------------
 */

/* Length of the sequence that begins here: those of status_screen.c alone. */
static size_t escape_len(const char *text)
{
    size_t n;

    MUST(text[0] == '\033' && text[1] == '[');
    n = 2 + strspn(text + 2, "0123456789;");
    MUST(text[n] && strchr("HJKm", text[n]));
    return n + 1;
}

static void check_screen(const char *text)
{
    while (*text) {
        const unsigned char b = (unsigned char)*text, next = (unsigned char)text[1];

        MUST(b >= 0x20 || b == '\033' || b == '\r' || b == '\n');
        MUST(b != 0x7f && !(b == 0xc2 && next >= 0x80 && next < 0xa0));
        text += b == '\033' ? escape_len(text) : 1;
    }
}

static void show_screen(const uint8_t *bytes, size_t len)
{
    const uint8_t *end = memchr(bytes, '\n', len);
    const size_t first = end ? (size_t)(end - bytes) : len;
    const struct dx_status_screen screen = {.columns = len ? 1 + bytes[0] % 160u : 80,
                                            .rows = 1 + (unsigned)(len % 60),
                                            .colours = len % 2,
                                            .trouble = len % 3 ? NULL : "no answer"};
    json_t *now = json_loadb((const char *)bytes, first, 0, NULL);
    json_t *before = end ? json_loadb((const char *)end, len - first, 0, NULL) : NULL;
    char *text = NULL;
    size_t text_len;
    FILE *out = open_memstream(&text, &text_len);

    MUST(out);
    dx_status_screen_put(out, &screen, now, before);
    MUST(fclose(out) == 0 && strlen(text) == text_len);
    check_screen(text);
    free(text);
    json_decref(now);
    json_decref(before);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    size_t command;

    if (len < 1 || len > sizeof(answer.bytes))
        return 0;
    if (!*path)
        start();
    command = bytes[0] % (SCREEN + 1);
    if (command == SCREEN) {
        show_screen(bytes + 1, len - 1);
        return 0;
    }
    pthread_mutex_lock(&answer.lock);
    answer.len = len - 1;
    memcpy(answer.bytes, bytes + 1, len - 1);
    pthread_mutex_unlock(&answer.lock);
    run(command);
    return 0;
}
