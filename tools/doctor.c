/* The topics of `dexel doctor`, one after the other, and their findings. */
#include "tools/doctor.h"

#include "core/base/plain_text.h"

#include <stdarg.h>
#include <stdio.h>

void dx_doctor_tell(struct dx_doctor *d, enum dx_doctor_level level, const char *mend,
                    const char *fmt, ...)
{
    static const char *const names[] = {"ok", "warning", "problem"};
    char text[1024];
    json_t *finding;
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(text, sizeof(text), fmt, ap);
    va_end(ap);
    dx_plain_text(text, strlen(text));
    finding = json_pack("{s:s, s:s, s:s}", "level", names[level], "topic", d->topic, "text", text);
    if (!finding) /* names of files need not be UTF-8 */
        finding = json_pack("{s:s, s:s, s:s}", "level", names[level], "topic", d->topic, "text",
                            "a text that is no UTF-8");
    if (mend)
        json_object_set_new(finding, "mend", json_string(mend));
    json_array_append_new(d->findings, finding);
    d->n_of[level]++;
}

void dx_doctor_run(struct dx_doctor *d)
{
    static const struct {
        const char *name;
        void (*look)(struct dx_doctor *d);
        bool needs_config;
    } topics[] = {
        /* the configuration first, which tells what is needed; streams before the service, which
         * would tell of what is missing once more */
        {"config", dx_doctor_config, false},   {"groups", dx_doctor_groups, false},
        {"sockets", dx_doctor_sockets, false}, {"rule", dx_doctor_rules, false},
        {"devices", dx_doctor_devices, false}, {"streams", dx_doctor_streams, true},
        {"service", dx_doctor_service, false}, {"modules", dx_doctor_modules, false},
        {"usb", dx_doctor_usb, false},         {"clocks", dx_doctor_clocks, false},
        {"disk", dx_doctor_disk, true},        {"limits", dx_doctor_limits, true},
        {"cpu", dx_doctor_processor, false},
    };

    dx_doctor_find_users(d);
    for (size_t k = 0; k < sizeof(topics) / sizeof(topics[0]); k++) {
        d->topic = topics[k].name;
        if (d->has_config || !topics[k].needs_config)
            topics[k].look(d);
    }
}
