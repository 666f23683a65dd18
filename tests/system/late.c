/*
 * late SOCKET: subscribers that join a running stream, in both encodings. Each holds after its
 * first COMMIT, and after those that follow, exactly the mesh that an early subscriber held at the
 * same epoch.
 */
#include "tests/system/follower.h"

#define N_JOINS  8
#define N_TRIES  32 /* the early one may itself have missed an epoch to compare with */
#define N_FOLLOW 3  /* commits of each that are compared */

/* Both have the epoch, or the early one is past it. */
static const struct follower_commit *await(struct follower *early, uint64_t epoch)
{
    while (early->last.epoch < epoch)
        followers_turn(&early, 1, -1);
    return follower_at(early, epoch);
}

/* How many of its commits could be compared; 0 unless the first was among them. */
static unsigned join(struct follower *early, const char *socket, enum dexel_encoding encoding)
{
    static struct follower late;
    struct follower *both[] = {early, &late};
    unsigned n_same = 0;

    memset(&late, 0, sizeof(late));
    late.name = encoding == DEXEL_Q16 ? "late, q16" : "late, f32";
    follower_open(&late, socket, NULL, encoding);
    for (unsigned k = 0; k < N_FOLLOW && n_same == k; k++) {
        const struct follower_commit *mine, *its;

        while (late.n_commits <= k)
            followers_turn(both, 2, -1);
        mine = follower_at(&late, late.last.epoch);
        its = await(early, late.last.epoch);
        if (its && (its->digest != mine->digest || its->commit.frame != mine->commit.frame))
            die("%s: epoch %llu, commit %u since it joined: another mesh", late.name,
                (unsigned long long)late.last.epoch, late.n_commits);
        n_same += its != NULL;
    }
    follower_close(&late);
    return n_same;
}

int main(int argc, char **argv)
{
    static struct follower early = {.name = "early"};
    struct follower *one = &early;
    unsigned n_joins = 0, n_same = 0, n_tries = 0;

    if (argc != 2)
        die("usage: late SOCKET");
    follower_open(&early, argv[1], NULL, DEXEL_Q16);
    while (early.n_commits < 5)
        followers_turn(&one, 1, -1);
    for (; n_joins < N_JOINS && n_tries < N_TRIES; n_tries++) {
        unsigned n = join(&early, argv[1], n_joins % 2 ? DEXEL_Q16 : DEXEL_F32);

        n_joins += n > 0;
        n_same += n;
    }
    printf("%u joins compared in %u tries, %u commits; the early one has %u commits\n", n_joins,
           n_tries, n_same, early.n_commits);
    if (early.n_resets || n_joins < N_JOINS)
        die("expected %d joins and no reset", N_JOINS);
    follower_close(&early);
    return 0;
}
