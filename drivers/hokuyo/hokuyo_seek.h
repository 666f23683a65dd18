/*
 * Which scanner on USB is the one that is meant, where several may be attached: by the serial
 * number of USB where it has one, else each is asked who it is, one after the other. Reader thread.
 */
#ifndef DX_HOKUYO_SEEK_H
#define DX_HOKUYO_SEEK_H

#include "drivers/hokuyo/scip_talk.h"

struct dx_hokuyo_seek;

/* Does the configuration leave open where the scanner is? */
bool dx_hokuyo_is_sought(const struct dx_hokuyo_config *config);

/* Lists what is attached. `serial`: "": any that is free. GONE: there is none; or negative. */
int dx_hokuyo_seek_new(struct dx_hokuyo_seek **out, const char *serial, struct dx_err *err);
void dx_hokuyo_seek_free(struct dx_hokuyo_seek *seek); /* NULL is fine */

/*
 * The next turn: 0: it is found, and the talk has its link. AGAIN: call again; a turn takes
 * DX_SCIP_READ_MS at most, and the talk's wake ends it. GONE: it is none of those attached;
 * negative: it may be one that cannot be had. err says what each of them is.
 */
int dx_hokuyo_seek_step(struct dx_hokuyo_seek *seek, struct dx_scip_talk *talk, struct dx_err *err);

/* A scanner has told who it is: what is in use by another stream cannot be asked. Any thread. */
void dx_hokuyo_seek_learn(const struct dx_scip_link *link, const char *serial);

/* -ENXIO with the text: the scanner at `place` has another serial number, or tells none. */
int dx_hokuyo_seek_wrong(struct dx_err *err, const char *place, const char *found,
                         const char *wanted);

#endif
