/*
 * Standard output that cannot be written: a command that looks at it in the middle ends, and main
 * tells of it once, for all commands. Owned by the main thread.
 */
#ifndef DX_STDOUT_H
#define DX_STDOUT_H

/* Prints a text that may be longer than what is kept to be written at once. */
void dx_stdout_put(const char *text);
void dx_stdout_put_line(const char *line); /* and a newline */

/* Has all been written that was printed? -errno: no, which is for dx_stdout_end() to tell. */
int dx_stdout_flush(void);

/* The same at the end: tells what was wrong. The exit status: `status`, but never 0 then. */
int dx_stdout_end(int status);

#endif
