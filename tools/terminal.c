/*
 * The terminal. What puts it back may be called by a signal's handler: it is write() and
 * tcsetattr() alone.
 */
#include "tools/terminal.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

/* the other screen, no cursor, lines end at the edge; and all of it back (xterm's, which all have)
 */
#define ENTER "\033[?1049h\033[?25l\033[?7l"
#define LEAVE "\033[?7h\033[?25h\033[?1049l"

static volatile sig_atomic_t entered;
static bool has_keys; /* standard input is a terminal as well */
static struct termios before, during;

bool dx_terminal_is_there(void)
{
    const char *term = getenv("TERM");

    return isatty(STDOUT_FILENO) && term && *term && strcmp(term, "dumb");
}

bool dx_terminal_has_colours(void)
{
    const char *no = getenv("NO_COLOR");

    return dx_terminal_is_there() && !(no && *no);
}

static void put(const char *text)
{
    ssize_t r = write(STDOUT_FILENO, text, strlen(text));

    (void)r;
}

static void take(void)
{
    if (has_keys)
        tcsetattr(STDIN_FILENO, TCSADRAIN, &during);
    put(ENTER);
    entered = 1;
}

void dx_terminal_leave(void)
{
    if (!entered)
        return;
    entered = 0;
    put(LEAVE);
    if (has_keys)
        tcsetattr(STDIN_FILENO, TCSADRAIN, &before);
}

/* Goes on as the signal would have without us. */
static void on_end(int number)
{
    dx_terminal_leave();
    signal(number, SIG_DFL);
    raise(number);
}

static void on_stop(int number)
{
    int saved = errno;

    (void)number;
    dx_terminal_leave();
    raise(SIGSTOP); /* and here it is continued */
    take();
    errno = saved;
}

static void on_size(int number)
{
    (void)number; /* it ends a wait */
}

static void handle(int number, void (*handler)(int))
{
    struct sigaction a = {.sa_handler = handler}; /* not SA_RESTART */

    sigaction(number, &a, NULL);
}

void dx_terminal_enter(void)
{
    static const int ends[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE};

    has_keys = isatty(STDIN_FILENO) && tcgetattr(STDIN_FILENO, &before) == 0;
    during = before;
    during.c_lflag &= ~(tcflag_t)(ICANON | ECHO);
    during.c_cc[VMIN] = 1;
    during.c_cc[VTIME] = 0;
    for (size_t k = 0; k < sizeof(ends) / sizeof(ends[0]); k++)
        handle(ends[k], on_end);
    handle(SIGTSTP, on_stop);
    handle(SIGWINCH, on_size);
    take();
}

void dx_terminal_size(unsigned *columns, unsigned *rows)
{
    struct winsize size = {0};

    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) < 0 || size.ws_col == 0 || size.ws_row == 0)
        size = (struct winsize){.ws_col = 80, .ws_row = 24};
    *columns = size.ws_col;
    *rows = size.ws_row;
}

int dx_terminal_key(int wait_ms)
{
    struct pollfd p = {has_keys ? STDIN_FILENO : -1, POLLIN, 0};
    unsigned char key;

    if (poll(&p, 1, wait_ms) <= 0)
        return DX_TERMINAL_NO_KEY;
    return read(STDIN_FILENO, &key, 1) == 1 ? key : DX_TERMINAL_END;
}
