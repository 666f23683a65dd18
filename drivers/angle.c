/* Angle sources: the choice among them, and the one that turns evenly. */
#include "drivers/angle.h"

#include "core/base/trig.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

struct constant {
    struct dx_angle_source source;
    struct dx_angle_config config;
};

/* Turns that a stage of this speed has made by `host_ns`. */
static double turned(const struct dx_angle_config *c, uint64_t host_ns)
{
    return (double)host_ns / 60e9 * c->rpm;
}

double dx_angle_constant(const struct dx_angle_config *c, uint64_t host_ns)
{
    double turns = turned(c, host_ns), swing = c->swing_deg / 360;

    if (swing > 0) {
        double at = fmod(turns, 2 * swing);

        turns = at > swing ? 2 * swing - at : at;
    }
    return dx_rad(c->start_deg) + 2 * DX_PI * (c->clockwise ? -turns : turns);
}

/* The next time after `host_ns` at which the stage turns back. */
static uint64_t next_return(const struct dx_angle_config *c, uint64_t host_ns)
{
    double swing = c->swing_deg / 360, next = (floor(turned(c, host_ns) / swing) + 1) * swing;

    return (uint64_t)(next / c->rpm * 60e9);
}

static size_t constant_samples(struct dx_angle_source *source, uint64_t from_ns, uint64_t until_ns,
                               struct dx_angle_sample *out, size_t max)
{
    const struct dx_angle_config *c = &((struct constant *)source)->config;
    size_t n = 0;

    out[n++] = (struct dx_angle_sample){from_ns, dx_angle_constant(c, from_ns), false};
    for (uint64_t t = from_ns; c->swing_deg > 0 && n + 1 < max;) {
        uint64_t next = next_return(c, t);

        t = next > t ? next : t + 1; /* by rounding it may be the one that was just there */
        if (t >= until_ns)
            break;
        out[n++] = (struct dx_angle_sample){t, dx_angle_constant(c, t), false};
    }
    if (until_ns > from_ns)
        out[n++] = (struct dx_angle_sample){until_ns, dx_angle_constant(c, until_ns), false};
    return n;
}

static int constant_pump(struct dx_angle_source *source, struct dx_err *err)
{
    (void)source;
    (void)err;
    return 0;
}

static void constant_trouble(const struct dx_angle_source *source, char *text, size_t len)
{
    (void)source;
    if (len)
        text[0] = 0;
}

static void constant_close(struct dx_angle_source *source)
{
    free(source);
}

static const struct dx_angle_ops constant_ops = {constant_pump, constant_samples, constant_trouble,
                                                 constant_close};

static int open_constant(struct dx_angle_source **out, const struct dx_angle_config *config,
                         struct dx_err *err)
{
    struct constant *c;

    if (!(config->rpm > 0 && config->rpm <= 6000) ||
        !(config->swing_deg >= 0 && config->swing_deg <= 360))
        return dx_err_set(err, -EINVAL,
                          "stage: %g rpm and a swing of %g degrees, expected > 0 and "
                          "0 to 360",
                          config->rpm, config->swing_deg);
    c = calloc(1, sizeof(*c));
    if (!c)
        return dx_err_set(err, -ENOMEM, "stage: no memory");
    c->source.ops = &constant_ops;
    c->config = *config;
    *out = &c->source;
    return 0;
}

static bool has_encoder(const struct dx_angle_config *c)
{
    return dx_gpio_where_given(c->encoder.a) || dx_gpio_where_given(c->encoder.b);
}

const char *dx_angle_check(const struct dx_angle_config *config, const char **key)
{
    if (has_encoder(config))
        return dx_encoder_check(&config->encoder, key);
    *key = "stage.rpm";
    return config->rpm > 0 ? NULL : "a stage needs its rpm, or the lines of its encoder";
}

int dx_angle_open(struct dx_angle_source **out, const struct dx_angle_config *config,
                  struct dx_err *err)
{
    return has_encoder(config) ? dx_encoder_open(out, &config->encoder, err)
                               : open_constant(out, config, err);
}

void dx_angle_close(struct dx_angle_source *source)
{
    if (source)
        source->ops->close(source);
}
