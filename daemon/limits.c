/* Bounds of what clients hold. Loop thread. */
#include "daemon/limits.h"

#include <limits.h>
#include <stdio.h>
#include <sys/resource.h>

#include "daemon/server_priv.h"

#define MIB           1048576.0
#define MAX_CLIENTS   256u
#define CLIENT_MEMORY (256ull << 20)
#define MAX_REQUESTS  100u
#define KEPT_FDS      32u /* an eighth of all, where that is less */

void dx_server_set_limits(struct dx_server *s, const struct dx_server_limits *limits)
{
    struct dx_server_limits *own = &s->options.limits;

    *own = *limits;
    if (!own->max_clients)
        own->max_clients = MAX_CLIENTS;
    if (!own->client_memory)
        own->client_memory = CLIENT_MEMORY;
    if (!own->max_requests)
        own->max_requests = MAX_REQUESTS;
}

static uint32_t n_of_user(const struct dx_server *s, uid_t uid)
{
    uint32_t n = 0;

    for (const struct dx_subscriber *sub = s->subscribers; sub; sub = sub->next)
        n += sub->phase != DX_SUBSCRIBER_CLOSED && sub->cred.uid == uid;
    return n;
}

/* Is it one of the last descriptors that there are? They are kept for whoever comes to see why, for
 * devices and recordings. The kernel gives the lowest that is free. */
static bool is_kept(int fd, unsigned *max)
{
    struct rlimit limit;
    rlim_t kept;

    if (getrlimit(RLIMIT_NOFILE, &limit) < 0 || limit.rlim_cur > INT_MAX)
        return false;
    kept = limit.rlim_cur / 8 < KEPT_FDS ? limit.rlim_cur / 8 : KEPT_FDS;
    *max = (unsigned)limit.rlim_cur;
    return (rlim_t)fd >= limit.rlim_cur - kept;
}

bool dx_limits_admit(const struct dx_server *s, int fd, const struct ucred *who,
                     char why[DX_WIRE_TEXT])
{
    unsigned max_fds;
    const struct dx_server_limits *l = &s->options.limits;

    *why = '\0';
    if (s->n_clients >= l->max_clients)
        snprintf(why, DX_WIRE_TEXT, "too many subscribers: %u (max_clients)", l->max_clients);
    else if (l->max_clients_per_uid && n_of_user(s, who->uid) >= l->max_clients_per_uid)
        snprintf(why, DX_WIRE_TEXT, "too many subscribers of user %u: %u (max_clients_per_uid)",
                 (unsigned)who->uid, l->max_clients_per_uid);
    else if (is_kept(fd, &max_fds))
        snprintf(why, DX_WIRE_TEXT,
                 "too few descriptors: the last of %u are for operators (LimitNOFILE=)", max_fds);
    return *why == '\0';
}

bool dx_limits_take(struct dx_subscriber *s, size_t len, char why[DX_WIRE_TEXT])
{
    struct dx_server *server = s->server;

    if (server->held_len + len > server->options.limits.client_memory) {
        snprintf(why, DX_WIRE_TEXT, "too much memory for subscribers: %.0f MiB (client_memory_mib)",
                 (double)server->options.limits.client_memory / MIB);
        return false;
    }
    s->held_len += len;
    server->held_len += len;
    return true;
}

void dx_limits_let_go(struct dx_subscriber *s)
{
    s->server->held_len -= s->held_len;
    s->held_len = 0;
}
