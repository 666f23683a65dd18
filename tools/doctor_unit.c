/* The service's unit and the drop-ins beside it: what they let it do. */
#include "tools/doctor.h"

#include <stdio.h>
#include <string.h>

#define FAMILIES "RestrictAddressFamilies="

static const char *const folders[] = {
    "/etc/systemd/system",     "/run/systemd/system", "/usr/local/lib/systemd/system",
    "/usr/lib/systemd/system", "/lib/systemd/system",
};

#define N_FOLDERS (sizeof(folders) / sizeof(folders[0]))

bool dx_doctor_read_unit(const struct dx_doctor *d, char *text, size_t len)
{
    for (size_t k = 0; k < N_FOLDERS; k++)
        if (dx_doctor_read_at(d, folders[k], "dexeld.service", text, len))
            return true;
    return false;
}

static bool names_network(const char *text)
{
    char families[256];

    return dx_doctor_line(text, FAMILIES, families, sizeof(families)) &&
           strstr(families, "AF_INET");
}

/* Drop-ins add to the families of the unit. */
static bool has_drop_in(const struct dx_doctor *d, const char *folder)
{
    char pattern[128], text[8192];
    bool has = false;
    glob_t g;

    snprintf(pattern, sizeof(pattern), "%s/dexeld.service.d/*.conf", folder);
    dx_doctor_glob(d, pattern, &g);
    for (size_t k = 0; k < g.gl_pathc && !has; k++)
        has =
            dx_doctor_read(d, dx_doctor_match(d, &g, k), text, sizeof(text)) && names_network(text);
    globfree(&g);
    return has;
}

bool dx_doctor_is_offline(const struct dx_doctor *d)
{
    char text[8192], families[256];

    if (!*d->pid || !dx_doctor_read_unit(d, text, sizeof(text)) ||
        !dx_doctor_line(text, FAMILIES, families, sizeof(families)) || names_network(text))
        return false;
    for (size_t k = 0; k < N_FOLDERS; k++)
        if (has_drop_in(d, folders[k]))
            return false;
    return true;
}

const char *dx_doctor_network_command(struct dx_doctor *d)
{
    static const char beside[] = "/usr/local/share/doc/dexeld/network.conf";
    struct stat st;

    return dx_doctor_command(
        d,
        "sudo install -D -m 644 @ /etc/systemd/system/dexeld.service.d/network.conf && "
        "sudo systemctl daemon-reload && sudo systemctl restart dexeld",
        dx_doctor_stat(d, beside, &st) ? beside : "/usr/share/doc/dexeld/network.conf");
}
