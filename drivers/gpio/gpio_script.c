/*
 * The back end for tests. What has happened waits in one queue (or in one for each line) until it
 * is read; a counter in an eventfd makes the descriptor readable as long as something waits.
 */
#include "drivers/gpio/gpio_script.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

struct waiting {
    struct dx_gpio_event event;
    bool is_taken;
};

struct dx_gpio_script {
    struct dx_gpio_bank bank;
    struct dx_gpio_port port;
    struct dx_gpio_script_faults faults;
    pthread_mutex_t mutex;
    int fd;
    bool is_open, is_gone;
    size_t n_steps, at; /* the next step */
    struct dx_gpio_script_step *steps;
    struct waiting *queue; /* what has happened, read from `head` on */
    size_t n_queue, max_queue, head;
    uint32_t seqno, last_read;
    uint64_t n_read;
    size_t n_lines;
    bool is_output[DX_GPIO_MAX_LINES], level[DX_GPIO_MAX_LINES];
    enum dx_gpio_edges edges[DX_GPIO_MAX_LINES];
    uint64_t n_sets[DX_GPIO_MAX_LINES];
};

static struct dx_gpio_script *of_port(const struct dx_gpio_port *port)
{
    return (struct dx_gpio_script *)((char *)(uintptr_t)port -
                                     offsetof(struct dx_gpio_script, port));
}

static void lock(struct dx_gpio_script *s)
{
    pthread_mutex_lock(&s->mutex);
}

static void unlock(struct dx_gpio_script *s)
{
    pthread_mutex_unlock(&s->mutex);
}

/* Readable while something waits, or when the chip is gone. */
static void signal_it(struct dx_gpio_script *s)
{
    bool waits = s->is_gone;
    uint64_t n = 1;

    for (size_t k = s->head; k < s->n_queue && !waits; k++)
        waits = !s->queue[k].is_taken;
    (void)!read(s->fd, &n, sizeof(n));
    n = 1;
    if (waits)
        (void)!write(s->fd, &n, sizeof(n));
}

static bool shares_queue(const struct dx_gpio_script *s, uint32_t a, uint32_t b)
{
    return !s->faults.per_line || a == b;
}

/* Makes room in the queue of `line`; false: the new event is the one that is dropped. */
static bool make_room(struct dx_gpio_script *s, uint32_t line)
{
    struct waiting *oldest = NULL;
    size_t n = 0;

    for (size_t k = s->head; k < s->n_queue && s->faults.fifo; k++) {
        if (s->queue[k].is_taken || !shares_queue(s, line, s->queue[k].event.line))
            continue;
        oldest = oldest ? oldest : &s->queue[k];
        n++;
    }
    if (!s->faults.fifo || n < s->faults.fifo)
        return true;
    if (s->faults.per_line)
        return false;
    oldest->is_taken = true;
    return true;
}

static void happen(struct dx_gpio_script *s, const struct dx_gpio_script_step *step)
{
    uint32_t number;
    bool is_lost;

    if (step->line >= DX_GPIO_MAX_LINES)
        return;
    s->level[step->line] = step->rising;
    if (!s->is_open || !(s->edges[step->line] & (step->rising ? DX_GPIO_RISING : DX_GPIO_FALLING)))
        return;
    number = ++s->seqno;
    is_lost = number > s->faults.lose_at && number <= s->faults.lose_at + s->faults.n_lose;
    if (is_lost || !make_room(s, step->line))
        return;
    if (s->n_queue == s->max_queue) {
        size_t max = s->max_queue ? 2 * s->max_queue : 64;
        struct waiting *more = realloc(s->queue, max * sizeof(*more));

        if (!more)
            return; /* one more lost */
        s->queue = more;
        s->max_queue = max;
    }
    s->queue[s->n_queue++] = (struct waiting){{step->t_ns, step->line, step->rising, false,
                                               s->faults.per_line ? 0
                                               : step->seqno      ? step->seqno
                                                                  : number},
                                              false};
    if (s->faults.swap_at && number == s->faults.swap_at && s->n_queue > 1) {
        struct waiting last = s->queue[s->n_queue - 1];

        s->queue[s->n_queue - 1] = s->queue[s->n_queue - 2];
        s->queue[s->n_queue - 2] = last;
    }
}

static void happen_bouncing(struct dx_gpio_script *s, struct dx_gpio_script_step step)
{
    happen(s, &step);
    for (int k = 0; k < 2 && s->faults.bounce_ns; k++) {
        step.rising = !step.rising;
        step.t_ns += s->faults.bounce_ns;
        happen(s, &step);
    }
}

void dx_gpio_script_begin(struct dx_gpio_script *s, uint64_t base_ns)
{
    lock(s);
    for (size_t k = s->at; k < s->n_steps; k++)
        s->steps[k].t_ns += base_ns;
    unlock(s);
}

void dx_gpio_script_advance(struct dx_gpio_script *s, uint64_t until_ns)
{
    lock(s);
    while (s->at < s->n_steps && s->steps[s->at].t_ns <= until_ns)
        happen_bouncing(s, s->steps[s->at++]);
    signal_it(s);
    unlock(s);
}

void dx_gpio_script_set_level(struct dx_gpio_script *s, uint32_t line, bool level, uint64_t t_ns)
{
    lock(s);
    if (s->level[line] != level)
        happen_bouncing(s, (struct dx_gpio_script_step){t_ns, line, level, 0});
    signal_it(s);
    unlock(s);
}

void dx_gpio_script_slip(struct dx_gpio_script *s, uint32_t line, bool level)
{
    lock(s);
    s->level[line] = level;
    unlock(s);
}

void dx_gpio_script_unplug(struct dx_gpio_script *s, bool gone)
{
    lock(s);
    s->is_gone = gone;
    signal_it(s);
    unlock(s);
}

/* ---- the table
 * ---------------------------------------------------------------------------------- */

static int find(const struct dx_gpio_bank *bank, const char *where, struct dx_gpio_place *place,
                struct dx_err *err)
{
    (void)bank;
    return dx_gpio_find(where, NULL, place, err);
}

static int request(struct dx_gpio_port **out, const struct dx_gpio_bank *bank,
                   const struct dx_gpio_line *lines, size_t n, const char *consumer,
                   struct dx_err *err)
{
    struct dx_gpio_script *s = (struct dx_gpio_script *)(uintptr_t)bank;
    struct dx_gpio_place place;
    int r = 0;

    (void)consumer;
    for (size_t k = 0; k < n && !r; k++)
        r = find(bank, lines[k].where, &place, err);
    if (r)
        return r;
    lock(s);
    if (s->faults.refuse || s->is_gone || s->is_open)
        r = dx_gpio_fail(err,
                         s->faults.refuse ? s->faults.refuse
                         : s->is_gone     ? -ENODEV
                                          : -EBUSY,
                         lines[0].where, "the line is not given");
    for (size_t k = 0; k < n && !r; k++) {
        s->is_output[k] = lines[k].output;
        s->edges[k] = lines[k].output ? DX_GPIO_NO_EDGE : lines[k].edges;
        if (lines[k].output)
            s->level[k] = lines[k].value;
    }
    if (!r) {
        s->n_lines = n;
        s->is_open = true;
        s->head = s->n_queue = 0;
        s->last_read = s->seqno;
        *out = &s->port;
    }
    unlock(s);
    return r;
}

/* One event, if it may be taken; how many that were. */
static int take(struct dx_gpio_script *s, struct waiting *w, struct dx_gpio_event *out)
{
    if (w->is_taken || (s->faults.gone_at && s->n_read >= s->faults.gone_at))
        return 0;
    *out = w->event;
    if (out->seqno) {
        out->overflow = out->seqno != s->last_read + 1;
        s->last_read = out->seqno;
    }
    w->is_taken = true;
    s->n_read++;
    return 1;
}

static int read_events(struct dx_gpio_port *port, struct dx_gpio_event *out, size_t max,
                       struct dx_err *err)
{
    struct dx_gpio_script *s = of_port(port);
    uint32_t n_queues = s->faults.per_line ? DX_GPIO_MAX_LINES : 1;
    int n = 0;

    lock(s);
    for (uint32_t line = 0; line < n_queues; line++)
        for (size_t k = s->head; k < s->n_queue && (size_t)n < max; k++)
            if (shares_queue(s, line, s->queue[k].event.line))
                n += take(s, &s->queue[k], &out[n]);
    while (s->head < s->n_queue && s->queue[s->head].is_taken)
        s->head++;
    if (s->head == s->n_queue)
        s->head = s->n_queue = 0;
    if (n == 0 && (s->is_gone || (s->faults.gone_at && s->n_read >= s->faults.gone_at)))
        n = dx_err_set(err, -ENODEV, "gpio: the chip is gone");
    signal_it(s);
    unlock(s);
    return n;
}

static int get(struct dx_gpio_port *port, size_t line, struct dx_err *err)
{
    struct dx_gpio_script *s = of_port(port);
    int value;

    lock(s);
    value = s->is_gone ? dx_err_set(err, -ENODEV, "gpio: the chip is gone") : (int)s->level[line];
    unlock(s);
    return value;
}

static int set(struct dx_gpio_port *port, size_t line, bool value, struct dx_err *err)
{
    struct dx_gpio_script *s = of_port(port);
    int r = 0;

    lock(s);
    if (s->is_gone)
        r = dx_err_set(err, -ENODEV, "gpio: the chip is gone");
    else if (!s->is_output[line])
        r = dx_err_set(err, -EPERM, "gpio: an input cannot be set");
    else
        s->level[line] = value;
    s->n_sets[line]++;
    unlock(s);
    return r;
}

static size_t descriptors(const struct dx_gpio_port *port, int fds[DX_GPIO_MAX_LINES])
{
    fds[0] = of_port(port)->fd;
    return 1;
}

static void release(struct dx_gpio_port *port)
{
    struct dx_gpio_script *s = of_port(port);

    lock(s);
    s->is_open = false;
    unlock(s);
}

static const struct dx_gpio_ops ops = {find, request, read_events, get, set, descriptors, release};

/* ---- made and looked at
 * ------------------------------------------------------------------------- */

int dx_gpio_script_new(struct dx_gpio_script **out, const struct dx_gpio_script_step *steps,
                       size_t n, const struct dx_gpio_script_faults *faults)
{
    struct dx_gpio_script *s = calloc(1, sizeof(*s));
    struct dx_gpio_script_step *copy = calloc(n + 1, sizeof(*copy));
    int fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);

    if (!s || !copy || fd < 0) {
        if (fd >= 0)
            close(fd);
        free(copy);
        free(s);
        return -ENOMEM;
    }
    if (n)
        memcpy(copy, steps, n * sizeof(*copy));
    s->bank.ops = &ops;
    s->port = (struct dx_gpio_port){&ops, !(faults && faults->per_line), false};
    if (faults)
        s->faults = *faults;
    pthread_mutex_init(&s->mutex, NULL);
    s->fd = fd;
    s->steps = copy;
    s->n_steps = n;
    *out = s;
    return 0;
}

void dx_gpio_script_free(struct dx_gpio_script *s)
{
    if (!s)
        return;
    pthread_mutex_destroy(&s->mutex);
    close(s->fd);
    free(s->queue);
    free(s->steps);
    free(s);
}

const struct dx_gpio_bank *dx_gpio_script_bank(struct dx_gpio_script *s)
{
    return &s->bank;
}

bool dx_gpio_script_level(struct dx_gpio_script *s, uint32_t line)
{
    bool level;

    lock(s);
    level = s->level[line];
    unlock(s);
    return level;
}

bool dx_gpio_script_is_open(struct dx_gpio_script *s)
{
    bool is_open;

    lock(s);
    is_open = s->is_open;
    unlock(s);
    return is_open;
}

uint64_t dx_gpio_script_n_sets(struct dx_gpio_script *s, uint32_t line)
{
    uint64_t n;

    lock(s);
    n = s->n_sets[line];
    unlock(s);
    return n;
}
