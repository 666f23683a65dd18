/* What of a configuration does not go together. */
#include "drivers/hokuyo/hokuyo.h"

#include <stddef.h>

const char *dx_hokuyo_check(const struct dx_hokuyo_config *c)
{
    const char *ways[] = {c->tty, c->tcp, c->port};
    unsigned n = 0;

    for (size_t k = 0; k < sizeof(ways) / sizeof(ways[0]); k++)
        n += ways[k] && ways[k][0];
    if (n > 1)
        return "found several of tty, tcp and port, expected one";
    if (c->first_step >= 0 && c->last_step >= 0 && c->first_step >= c->last_step)
        return "found a last_step that is not behind first_step";
    return dx_stage_check(&c->stage);
}
