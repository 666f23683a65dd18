/*
 * Seeking a scanner among those on USB. Several streams may seek at once, and each is kept from
 * what another has claimed: so one that is in use is tried again for a while, as it may be asked
 * only.
 */
#include "drivers/hokuyo/hokuyo_seek.h"

#include "drivers/monotonic.h"
#include "drivers/udev.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_FOUND 16
#define S_NS      UINT64_C(1000000000)
#define ASK_NS    (3 * S_NS) /* for a scanner to say who it is */
#define BUSY_NS   (2 * S_NS) /* for other streams to be done with asking */
#define NAP_MS    20         /* before what is in use is tried again */

enum verdict {
    UNKNOWN, /* not tried yet, or to be tried again */
    BUSY,    /* someone else has it */
    OTHER,   /* it is another one than is wanted */
    FAILED,  /* it cannot be had, or does not answer */
};

struct candidate {
    char node[64], port[32];
    char usb_serial[64];
    char told[64]; /* OTHER: what it says itself; UNKNOWN: what it said before, "": not known */
    enum verdict verdict;
    struct dx_err why; /* BUSY, FAILED */
    int code;
};

struct dx_hokuyo_seek {
    char serial[64]; /* wanted; "": any */
    struct candidate list[MAX_FOUND];
    unsigned n, at;
    uint64_t ask_until_ns;  /* list[at] */
    uint64_t busy_until_ns; /* 0: nothing was in use yet */
};

bool dx_hokuyo_is_sought(const struct dx_hokuyo_config *c)
{
    return !(c->tty && c->tty[0]) && !(c->tcp && c->tcp[0]) && !(c->port && c->port[0]);
}

/* ---- what scanners have told ------------------------------------------------------------------
 */

/* By the node, of which the kernel gives each plugging a new one; so what is here grows old only
 * when its numbers begin anew, and it is a hint. */
static struct {
    pthread_mutex_t mutex;
    struct {
        char node[64], serial[64];
    } of[MAX_FOUND];
    unsigned next;
} known = {.mutex = PTHREAD_MUTEX_INITIALIZER};

void dx_hokuyo_seek_learn(const struct dx_scip_link *link, const char *serial)
{
    unsigned k = 0;

    if (!link->node[0])
        return;
    pthread_mutex_lock(&known.mutex);
    while (k < MAX_FOUND && strcmp(known.of[k].node, link->node) != 0)
        k++;
    if (k == MAX_FOUND)
        k = known.next++ % MAX_FOUND;
    snprintf(known.of[k].node, sizeof(known.of[k].node), "%s", link->node);
    snprintf(known.of[k].serial, sizeof(known.of[k].serial), "%s", serial);
    pthread_mutex_unlock(&known.mutex);
}

static void recall(struct candidate *c)
{
    pthread_mutex_lock(&known.mutex);
    for (unsigned k = 0; k < MAX_FOUND; k++)
        if (!strcmp(known.of[k].node, c->node))
            memcpy(c->told, known.of[k].serial, sizeof(c->told));
    pthread_mutex_unlock(&known.mutex);
}

/* ---- the list ---------------------------------------------------------------------------------
 */

static bool take(void *ctx, const struct dx_udev_device *d)
{
    struct dx_hokuyo_seek *s = ctx;
    struct candidate *c = &s->list[s->n];

    if (d->vendor != DX_HOKUYO_USB_VENDOR || d->product != DX_HOKUYO_USB_PRODUCT)
        return true;
    snprintf(c->node, sizeof(c->node), "%s", d->node);
    snprintf(c->port, sizeof(c->port), "%s", d->port);
    snprintf(c->usb_serial, sizeof(c->usb_serial), "%s", d->serial);
    recall(c);
    return ++s->n < MAX_FOUND;
}

int dx_hokuyo_seek_new(struct dx_hokuyo_seek **out, const char *serial, struct dx_err *err)
{
    struct dx_hokuyo_seek *s = calloc(1, sizeof(*s));
    int r;

    if (!s)
        return dx_err_set(err, -ENOMEM, "hokuyo: no memory");
    snprintf(s->serial, sizeof(s->serial), "%s", serial);
    r = dx_udev_each("usb", take, s, err);
    if (r == 0 && s->n == 0)
        r = dx_err_set(err, DX_DRIVER_E_GONE, "no USB device %04x:%04x%s%s is there",
                       DX_HOKUYO_USB_VENDOR, DX_HOKUYO_USB_PRODUCT, *serial ? ", serial " : "",
                       serial);
    if (r) {
        free(s);
        return r;
    }
    *out = s;
    return 0;
}

void dx_hokuyo_seek_free(struct dx_hokuyo_seek *s)
{
    free(s);
}

static bool is_wanted(const struct dx_hokuyo_seek *s, const char *serial)
{
    return s->serial[0] && !strcmp(s->serial, serial);
}

/* Those that are probably it come first, and those last that were another before. */
static int rank(const struct dx_hokuyo_seek *s, const struct candidate *c)
{
    if (is_wanted(s, c->usb_serial) || is_wanted(s, c->told))
        return 0;
    return c->told[0] && s->serial[0] ? 2 : 1;
}

/* False: all have been tried. */
static bool next(struct dx_hokuyo_seek *s)
{
    int best = 3;

    for (unsigned k = 0; k < s->n; k++)
        if (s->list[k].verdict == UNKNOWN && rank(s, &s->list[k]) < best) {
            best = rank(s, &s->list[k]);
            s->at = k;
        }
    return best < 3;
}

/* ---- the end ----------------------------------------------------------------------------------
 */

int dx_hokuyo_seek_wrong(struct dx_err *err, const char *place, const char *found,
                         const char *wanted)
{
    if (!found[0])
        return dx_err_set(err, -ENXIO, "%s: the scanner tells no serial number, expected '%s'",
                          place, wanted);
    return dx_err_set(err, -ENXIO, "%s: serial number is '%s', expected '%s'", place, found,
                      wanted);
}

/* "usb 1-1 has 'H0614967'" */
static void tell(const struct candidate *c, char *text, size_t len)
{
    if (c->verdict != OTHER)
        snprintf(text, len, "%.150s", c->why.text);
    else if (c->told[0])
        snprintf(text, len, "usb %s has '%s'", c->port, c->told);
    else
        snprintf(text, len, "usb %s tells none", c->port);
}

/* It is none of them; or, if one of them cannot be had, perhaps that one. */
static int none(const struct dx_hokuyo_seek *s, struct dx_err *err)
{
    char text[400], all[600] = "";
    int r = DX_DRIVER_E_GONE;
    size_t at = 0;

    for (unsigned k = 0; k < s->n && at < sizeof(all); k++) {
        const struct candidate *c = &s->list[k];

        if (r > 0 && c->verdict != OTHER)
            r = c->code;
        tell(c, text, sizeof(text));
        at += (size_t)snprintf(all + at, sizeof(all) - at, "%s%s", k ? "; " : "", text);
    }
    if (!s->serial[0])
        return dx_err_set(err, r, "%s", all);
    return dx_err_set(err, r, "no scanner with serial number '%s': %s", s->serial, all);
}

/* All have been tried. Those that were in use may be free by now. */
static int go_round(struct dx_hokuyo_seek *s, struct dx_err *err)
{
    uint64_t now = dx_clock_ns();
    bool any = false;

    if (!s->busy_until_ns)
        s->busy_until_ns = now + BUSY_NS;
    for (unsigned k = 0; k < s->n && s->serial[0] && now < s->busy_until_ns; k++)
        if (s->list[k].verdict == BUSY) {
            s->list[k].verdict = UNKNOWN;
            any = true;
        }
    if (!any)
        return none(s, err);
    poll(NULL, 0, NAP_MS);
    return DX_DRIVER_E_AGAIN;
}

/* ---- asking -----------------------------------------------------------------------------------
 */

static int settle(struct candidate *c, struct dx_scip_talk *talk, enum verdict verdict, int code)
{
    c->verdict = verdict;
    c->code = code;
    dx_scip_talk_set_link(talk, NULL);
    return DX_DRIVER_E_AGAIN;
}

/* A scanner that went meanwhile is as good as none; one that is in use, and was another, is so
 * still. */
static int refused(const struct dx_hokuyo_seek *s, struct candidate *c, struct dx_scip_talk *talk,
                   int code)
{
    if (code != -EBUSY)
        return settle(c, talk, FAILED, code);
    return settle(c, talk, s->serial[0] && c->told[0] && !is_wanted(s, c->told) ? OTHER : BUSY,
                  code);
}

/* 0: this is the one. */
static int open_candidate(struct dx_hokuyo_seek *s, struct candidate *c, struct dx_scip_talk *talk)
{
    const struct dx_scip_want want = {.first_step = -1, .last_step = -1, .cluster = 1};
    struct dx_scip_link *link;
    int r = dx_scip_link_open_usb(&link, c->port, &c->why);

    if (r)
        return refused(s, c, talk, r);
    dx_scip_talk_set_link(talk, link);
    if (!s->serial[0] || is_wanted(s, c->usb_serial))
        return 0;
    s->ask_until_ns = dx_clock_ns() + ASK_NS;
    r = dx_scip_talk_begin(talk, &want, 0, &c->why);
    return r ? settle(c, talk, FAILED, r) : DX_DRIVER_E_AGAIN;
}

/* Nothing but its name is asked for: its laser stays off. */
static int ask(struct dx_hokuyo_seek *s, struct candidate *c, struct dx_scip_talk *talk)
{
    const struct dx_scip_session *session = &talk->session;
    uint64_t now = dx_clock_ns(), until = now + DX_SCIP_READ_MS * UINT64_C(1000000);
    int r = dx_scip_talk_step(talk, until, &c->why);

    while (dx_scip_talk_feed(talk) == 0)
        ; /* it was left streaming */
    if (session->is_known) {
        snprintf(c->told, sizeof(c->told), "%s", session->identity.serial);
        dx_hokuyo_seek_learn(talk->link, c->told);
        return is_wanted(s, c->told) ? 0 : settle(c, talk, OTHER, 0);
    }
    if (r && r != DX_DRIVER_E_AGAIN)
        return settle(c, talk, FAILED, r);
    if (now < s->ask_until_ns)
        return DX_DRIVER_E_AGAIN;
    dx_err_set(&c->why, -ETIMEDOUT, "%s does not say who it is", talk->link->place);
    return settle(c, talk, FAILED, -ETIMEDOUT);
}

int dx_hokuyo_seek_step(struct dx_hokuyo_seek *s, struct dx_scip_talk *talk, struct dx_err *err)
{
    if (dx_scip_talk_take_wake(talk))
        return DX_DRIVER_E_AGAIN;
    if (talk->link)
        return ask(s, &s->list[s->at], talk);
    return next(s) ? open_candidate(s, &s->list[s->at], talk) : go_round(s, err);
}
