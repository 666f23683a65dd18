/*
 * reload_watch SOCKET CONTROL CONFIG NEXT: subscribers while NEXT takes the place of the
 * configuration file. Of the streams, `still` and `run` are the same in both, `box` is another one,
 * `gone` is not in NEXT, and `come` is only there. Who is on `still` or `run` sees no RESET, and of
 * `run`, a lossless replay that waits for its subscribers, every epoch; who is on `box` is told
 * RESET once and then holds exactly the new mesh; who is on `gone` is told so.
 */
#include "tests/system/follower.h"
#include "tools/control_client.h"

#include <errno.h>
#include <sys/wait.h>
#include <unistd.h>

#define RELOAD_MS 200000 /* guards against hanging, as FOLLOWER_SILENCE_MS does */

enum { STILL, RUN, BOX, BOX_Q16, N_STAY, GONE = N_STAY, N_ALL };

static struct follower all[N_ALL] = {{.name = "still"},
                                     {.name = "run", .mode = DEXEL_LOSSLESS},
                                     {.name = "box"},
                                     {.name = "box, q16"},
                                     {.name = "gone", .may_fail = true}};
static struct follower *const each[N_ALL] = {&all[0], &all[1], &all[2], &all[3], &all[4]};

static void open_all(const char *socket)
{
    static const struct {
        const char *stream;
        enum dexel_encoding encoding;
    } as[N_ALL] = {{"still", DEXEL_Q16},
                   {"run", DEXEL_F32},
                   {"box", DEXEL_F32},
                   {"box", DEXEL_Q16},
                   {"gone", DEXEL_F32}};

    for (int k = 0; k < N_ALL; k++)
        follower_open(each[k], socket, as[k].stream, as[k].encoding);
}

/* Until each of the first n has so many commits more. */
static void await_commits(unsigned n, unsigned more)
{
    unsigned due[N_ALL];

    for (unsigned k = 0; k < n; k++)
        due[k] = each[k]->n_commits + more;
    for (unsigned k = 0; k < n; k++)
        while (each[k]->n_commits < due[k])
            followers_turn(each, n, -1);
}

static void await_error(struct follower *f, const char *text)
{
    while (!f->failed)
        followers_turn(each, N_ALL, -1);
    if (!strstr(dexel_error(f->d), text))
        die("%s: found '%s', expected '%s'", f->name, dexel_error(f->d), text);
}

/* A subscriber that comes after it all holds the same at the same epoch. */
static void check_beside_a_new_one(struct follower *f, const char *socket, const char *stream)
{
    struct follower late = {.name = "late"};
    struct follower *both[] = {f, &late};
    const struct follower_commit *a = NULL, *b = NULL;

    follower_open(&late, socket, stream, DEXEL_F32);
    while (!a || !b) {
        followers_turn(both, 2, -1);
        b = late.n_commits ? follower_at(&late, late.last.epoch) : NULL;
        a = b ? follower_at(f, late.last.epoch) : NULL;
    }
    if (a->digest != b->digest || !a->digest)
        die("%s: holds another mesh than a new subscriber", f->name);
    follower_close(&late);
}

static void expect(const char *reply, const char *part)
{
    if (!strstr(reply, part))
        die("reload: answered '%s', expected '%s' in it", reply, part);
}

/* Asks in a process of its own and returns where its answer comes: a reload may take longer than a
 * service waits for subscribers who do not read. */
static int ask_beside(const char *control, pid_t *pid)
{
    int ends[2];
    struct dx_err err;
    char *reply;

    if (pipe(ends) < 0 || (*pid = fork()) < 0)
        die("%s", strerror(errno));
    if (*pid) {
        close(ends[1]);
        return ends[0];
    }
    if (dx_control_ask_within(&reply, control, "{\"request\":\"reload\"}", RELOAD_MS, NULL, &err) <
        0)
        reply = err.text;
    _exit(write(ends[1], reply, strlen(reply)) < 0 ? 1 : 0);
}

static void reload(const char *control, const char *config, const char *next)
{
    char reply[4096];
    ssize_t len;
    pid_t pid;
    int answer;

    if (rename(next, config) < 0)
        die("%s: %s", next, strerror(errno));
    answer = ask_beside(control, &pid);
    while (!followers_turn(each, N_ALL, answer))
        ;
    len = read(answer, reply, sizeof(reply) - 1);
    if (len < 0 || waitpid(pid, NULL, 0) < 0)
        die("reload: %s", strerror(errno));
    reply[len] = '\0';
    close(answer);
    expect(reply, "\"added\":[\"come\"]");
    expect(reply, "\"changed\":[\"box\"]");
    expect(reply, "\"removed\":[\"gone\"]");
    expect(reply, "\"unchanged\":[\"still\",\"run\"]");
    expect(reply, "\"restart\":[]");
}

static void check(const char *socket)
{
    struct follower come = {.name = "come"};
    struct follower *one = &come;

    if (all[STILL].n_resets || all[RUN].n_resets || all[RUN].n_missed)
        die("%u and %u resets, %u epochs missed, expected none", all[STILL].n_resets,
            all[RUN].n_resets, all[RUN].n_missed);
    for (int k = BOX; k <= BOX_Q16; k++) {
        if (all[k].n_resets != 1 || all[k].n_tiles != 15)
            die("%s: %u resets, %u tiles, expected 1 and 15", all[k].name, all[k].n_resets,
                all[k].n_tiles);
        check_beside_a_new_one(&all[k], socket, "box");
    }
    follower_open(&come, socket, "come", DEXEL_DELTA);
    while (come.n_commits < 3)
        followers_turn(&one, 1, -1);
    follower_close(&come);
}

int main(int argc, char **argv)
{
    if (argc != 5)
        die("usage: reload_watch SOCKET CONTROL CONFIG NEXT");
    open_all(argv[1]);
    await_commits(N_ALL, 3);
    reload(argv[2], argv[3], argv[4]);
    await_error(each[GONE], "the configuration has no stream 'gone' any more");
    while (!all[BOX].n_resets || !all[BOX_Q16].n_resets)
        followers_turn(each, N_STAY, -1);
    await_commits(N_STAY, 5);
    check(argv[1]);
    for (int k = 0; k < N_ALL; k++)
        follower_close(each[k]);
    return 0;
}
