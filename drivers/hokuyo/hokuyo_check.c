/* What of a configuration does not go together. */
#include "drivers/hokuyo/hokuyo.h"

#include "drivers/hokuyo/scip_link.h"

#include <stdio.h>

static bool is_address(const char *tcp)
{
    const char *host, *port;
    char text[300];

    return snprintf(text, sizeof(text), "%s", tcp) < (int)sizeof(text) &&
           dx_scip_tcp_split(text, &host, &port);
}

const char *dx_hokuyo_check(const struct dx_hokuyo_config *c, const char **key)
{
    const struct {
        const char *key, *value;
    } ways[] = {{"tty", c->tty}, {"tcp", c->tcp}, {"port", c->port}};
    unsigned n = 0;

    for (size_t k = 0; k < sizeof(ways) / sizeof(ways[0]); k++) {
        *key = ways[k].key;
        n += ways[k].value && ways[k].value[0];
        if (n > 1)
            return "found several of tty, tcp and port, expected one";
    }
    *key = "tcp";
    if (c->tcp && c->tcp[0] && !is_address(c->tcp))
        return "found a tcp that is no address, expected HOST or HOST:PORT";
    *key = "last_step";
    if (c->first_step >= 0 && c->last_step >= 0 && c->first_step >= c->last_step)
        return "found a last_step that is not behind first_step";
    return dx_stage_check(&c->stage, key);
}
