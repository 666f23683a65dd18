/* Flushing, and why it failed first: what the C library could not write it forgets. */
#include "tools/stdout.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static int trouble;

static void note(bool is_bad)
{
    if (is_bad && !trouble)
        trouble = errno ? errno : EIO;
}

void dx_stdout_put(const char *text)
{
    errno = 0;
    note(fputs(text, stdout) == EOF);
}

void dx_stdout_put_line(const char *line)
{
    errno = 0;
    note(puts(line) == EOF);
}

int dx_stdout_flush(void)
{
    errno = 0; /* that of an earlier write is gone; flush tells it again */
    note(fflush(stdout) != 0 || ferror(stdout));
    return -trouble;
}

int dx_stdout_end(int status)
{
    if (dx_stdout_flush() == 0)
        return status;
    fprintf(stderr, "dexel: standard output: %s\n", strerror(trouble));
    return status ? status : 1;
}
