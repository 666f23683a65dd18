/*
 * Rounds of tests that take longest and start no thread: a tenth under ThreadSanitizer, which makes
 * each ten times as slow and looks for what these have not. Bounds on how often something was seen
 * are counted in rounds as well.
 */
#ifndef ROUNDS_H
#define ROUNDS_H

#ifdef __SANITIZE_THREAD__
#define ROUNDS(n) ((n) / 10)
#else
#define ROUNDS(n) (n)
#endif

#endif
