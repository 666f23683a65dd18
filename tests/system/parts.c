/*
 * parts SOCKET: the streams `whole` and `parts` are the same scene, the second delivered in
 * columns. At the end of each frame both are the same mesh; on the way there parts of it are
 * committed.
 */
#include "tests/system/follower.h"

#define N_FRAMES 15
#define MAX_SEEN 1024

/* The digest at the end of each frame; 0: not seen (or no mesh, which does not happen). */
static void note(uint64_t seen[MAX_SEEN], const struct follower *f)
{
    if (f->n_commits && !f->last.partial && f->last.frame < MAX_SEEN)
        seen[f->last.frame] = follower_at(f, f->last.epoch)->digest;
}

int main(int argc, char **argv)
{
    static struct follower whole = {.name = "whole"}, parts = {.name = "parts"};
    static uint64_t seen[2][MAX_SEEN];
    struct follower *both[] = {&whole, &parts};
    unsigned n_same = 0, n_distinct = 0;

    if (argc != 2)
        die("usage: parts SOCKET");
    follower_open(&whole, argv[1], "whole", DEXEL_F32);
    follower_open(&parts, argv[1], "parts", DEXEL_Q16);
    while (n_same < N_FRAMES && whole.last.frame < MAX_SEEN) {
        followers_turn(both, 2, -1);
        note(seen[0], &whole);
        note(seen[1], &parts);
        n_same = n_distinct = 0;
        for (unsigned k = 0; k < MAX_SEEN; k++) {
            if (!seen[0][k] || !seen[1][k])
                continue;
            if (seen[0][k] != seen[1][k])
                die("frame %u: another mesh in parts than as a whole", k);
            n_same++;
            n_distinct += k > 0 && seen[0][k] != seen[0][k - 1];
        }
    }
    printf("%u frames the same, %u partial commits of %u\n", n_same, parts.n_partial,
           parts.n_commits);
    if (n_same < N_FRAMES || n_distinct < N_FRAMES - 1 || parts.n_partial < N_FRAMES)
        die("expected %d frames, all different, and as many partial commits", N_FRAMES);
    if (whole.n_partial)
        die("%u partial commits of whole frames", whole.n_partial);
    follower_close(&whole);
    follower_close(&parts);
    return 0;
}
