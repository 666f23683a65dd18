/*
 * What the clients of the mesh socket may make the service hold: connections, in all and of one
 * user, and memory. A text says which bound was met, and goes to the client and to the log. Loop
 * thread.
 */
#ifndef DX_LIMITS_H
#define DX_LIMITS_H

#include <stdbool.h>
#include <stddef.h>

#include "core/wire/wire.h"

struct dx_server;
struct dx_subscriber;
struct ucred;

/* May one more connection, which has the descriptor `fd`, come, of this process? */
bool dx_limits_admit(const struct dx_server *s, int fd, const struct ucred *who,
                     char why[DX_WIRE_TEXT]);

/* May the subscriber hold so many bytes more? They are counted until it lets go of all. */
bool dx_limits_take(struct dx_subscriber *s, size_t len, char why[DX_WIRE_TEXT]);
void dx_limits_let_go(struct dx_subscriber *s);

#endif
