/*
 * A terminal that a command takes over for a live screen: the other screen, keys as they are typed
 * and without echo. It is put back when the command leaves, is interrupted, ended or stopped by a
 * signal. One of it a process; one thread.
 */
#ifndef DX_TERMINAL_H
#define DX_TERMINAL_H

#include <stdbool.h>

/* Standard output is a terminal where a cursor can be moved. */
bool dx_terminal_is_there(void);
/* And colours are wanted: not where NO_COLOR is set (no-color.org). */
bool dx_terminal_has_colours(void);

void dx_terminal_enter(void);
void dx_terminal_leave(void); /* nothing when it was not entered */

/* As it is now; 80 x 24 where it does not say. */
void dx_terminal_size(unsigned *columns, unsigned *rows);

#define DX_TERMINAL_NO_KEY 0
#define DX_TERMINAL_END    (-1) /* standard input has ended */

/* Waits for a key, `wait_ms` at most, less when the size changes: a byte, or one of the above. */
int dx_terminal_key(int wait_ms);

#endif
