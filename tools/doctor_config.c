/* The configuration, as `dexeld --check` reads it. */
#include "tools/doctor.h"

#include <string.h>

static const char *find_config(const struct dx_doctor *d)
{
    static const char *const places[] = {"/etc/dexeld/dexeld.yaml",
                                         "/usr/local/etc/dexeld/dexeld.yaml"};
    struct stat st;

    if (d->config_path)
        return d->config_path;
    for (size_t k = 0; k < sizeof(places) / sizeof(places[0]); k++)
        if (dx_doctor_stat(d, places[k], &st))
            return places[k];
    return NULL;
}

void dx_doctor_config(struct dx_doctor *d)
{
    char whole[PATH_MAX];
    struct dx_err err;

    d->config_path = find_config(d);
    if (!d->config_path) {
        dx_doctor_tell(
            d, DX_DOCTOR_WARNING,
            "sudo apt-get install --reinstall -o Dpkg::Options::=--force-confmiss dexeld",
            "there is no /etc/dexeld/dexeld.yaml; what it would ask for was not looked at");
        return;
    }
    dx_doctor_path(d, whole, sizeof(whole), d->config_path);
    if (dx_config_load(&d->config, whole, &err) < 0) {
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM, dx_doctor_edit_command(d),
                       "%s; what it asks for was not looked at", err.text);
        return;
    }
    d->has_config = true;
    dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s: %u streams", d->config_path, d->config.n_streams);
}

const struct dx_stream_config *dx_doctor_stream(const struct dx_doctor *d, const char *name)
{
    for (uint32_t k = 0; k < d->config.n_streams; k++)
        if (!strcmp(d->config.streams[k].name, name))
            return &d->config.streams[k];
    return NULL;
}

unsigned dx_doctor_n_streams(const struct dx_doctor *d, const char *driver)
{
    unsigned n = 0;

    for (uint32_t k = 0; k < d->config.n_streams; k++)
        n += !strcmp(d->config.streams[k].driver, driver);
    return n;
}

static const struct dx_encoder_config *encoder_of(const struct dx_stream_config *s)
{
    return strcmp(s->driver, "hokuyo") ? NULL : &s->source.hokuyo.stage.angle.encoder;
}

bool dx_doctor_wants_gpio(const struct dx_doctor *d)
{
    for (uint32_t k = 0; k < d->config.n_streams; k++) {
        const struct dx_stream_config *s = &d->config.streams[k];
        const struct dx_encoder_config *e = encoder_of(s);

        if (dx_rig_is_wanted(&s->gpio) || (e && dx_gpio_where_given(e->a)))
            return true;
    }
    return false;
}
