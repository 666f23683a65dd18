/*
 * Rounds of the tests that take longest: a tenth under ThreadSanitizer, which makes each ten times
 * as slow, and looks for what one has as well as another. Bounds on how often something was seen
 * are counted in rounds as well; of what is tried in turn, each tenth is. Where the first rounds
 * see less than the others, a tenth of them has a bound of its own (OF_ROUNDS).
 */
#ifndef ROUNDS_H
#define ROUNDS_H

#ifdef __SANITIZE_THREAD__
#define EACH 10
#else
#define EACH 1
#endif
#define ROUNDS(n)               ((n) / EACH)
#define OF_ROUNDS(whole, tenth) (EACH == 1 ? (whole) : (tenth))

#endif
