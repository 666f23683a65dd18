/* log-level and quit, of the control socket. */
#include "daemon/control_service.h"

#include "daemon/config_table.h"
#include "daemon/log.h"
#include "daemon/server.h"

static json_t *level_in_force(const struct dx_config_key *key)
{
    const struct dx_config_word *w = key->words;

    while (w->text && w->value != dx_log_level())
        w++;
    return json_pack("{s:s}", "level", w->text ? w->text : "none");
}

json_t *dx_control_log_level(struct dx_server *server, const json_t *request)
{
    const struct dx_config_key *key = dx_config_key_find("log_level");
    const json_t *given = json_object_get(request, "level");
    char allowed[DX_CONFIG_ALLOWED_LEN];
    struct dx_config config = {0};

    (void)server;
    if (!given)
        return level_in_force(key);
    if (!json_is_string(given) || dx_config_value_set(key, &config, json_string_value(given)) < 0) {
        dx_config_value_allowed(key, allowed);
        return json_pack("{s:o}", "error", json_sprintf("\"level\": expected %s", allowed));
    }
    dx_log_set_level(config.log_level);
    return level_in_force(key);
}

json_t *dx_control_quit(struct dx_server *server, const json_t *request)
{
    (void)request;
    dx_server_stop(server);
    return json_object();
}
