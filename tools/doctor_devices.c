/* Devices that are attached, the permissions of their nodes, and the udev rule that sets them. */
#include "tools/doctor.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define RULE      "60-dexeld.rules"
#define REINSTALL "sudo apt-get install --reinstall dexeld"
#define TRIGGER   "sudo udevadm control --reload && sudo udevadm trigger --action=add --name-match=@"
#define MAX_USB   32

/* ---- the rule ---------------------------------------------------------------------------------
 */

bool dx_doctor_has_rule(const struct dx_doctor *d, char *path, size_t len)
{
    static const char *const folders[] = {"/etc/udev/rules.d", "/run/udev/rules.d",
                                          "/usr/local/lib/udev/rules.d", "/usr/lib/udev/rules.d",
                                          "/lib/udev/rules.d"};
    struct stat st;

    for (size_t k = 0; k < sizeof(folders) / sizeof(folders[0]); k++) {
        snprintf(path, len, "%s/" RULE, folders[k]);
        if (dx_doctor_stat(d, path, &st))
            return true;
    }
    return false;
}

void dx_doctor_rules(struct dx_doctor *d)
{
    struct dx_doctor_usb usb[1];
    char path[PATH_MAX], text[64];

    if (!dx_doctor_has_rule(d, path, sizeof(path)))
        dx_doctor_tell(
            d, dx_doctor_usb_devices(d, NULL, usb, 1) ? DX_DOCTOR_PROBLEM : DX_DOCTOR_WARNING,
            REINSTALL, "the udev rule " RULE " is not installed");
    else if (dx_doctor_read(d, path, text, sizeof(text)) && !*text)
        dx_doctor_tell(d, DX_DOCTOR_PROBLEM,
                       dx_doctor_command(d, "sudo rm @ && sudo udevadm control --reload", path),
                       "%s is empty, and hides the rule", path);
    else
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s is installed", path);
}

/* ---- USB --------------------------------------------------------------------------------------
 */

/* Those that 60-dexeld.rules names. */
static const struct {
    const char *vendor, *product, *driver, *name;
} known[] = {
    {"15d1", "0000", "hokuyo", "Hokuyo scanner"},
    {"045e", "02ae", "kinect", "camera of Kinect for Xbox 360"},
    {"045e", "02bf", "kinect", "camera of Kinect for Windows"},
};

#define N_KNOWN (sizeof(known) / sizeof(known[0]))

static unsigned number(const struct dx_doctor *d, const char *folder, const char *name)
{
    char text[16];

    return dx_doctor_read_at(d, folder, name, text, sizeof(text))
               ? (unsigned)strtoul(text, NULL, 10)
               : 0;
}

/* False: none of ours. */
static bool describe_usb(const struct dx_doctor *d, struct dx_doctor_usb *out, const char *folder)
{
    char vendor[16], product[16];
    size_t k = 0;

    dx_doctor_read_at(d, folder, "idVendor", vendor, sizeof(vendor));
    dx_doctor_read_at(d, folder, "idProduct", product, sizeof(product));
    while (k < N_KNOWN && (strcmp(known[k].vendor, vendor) || strcmp(known[k].product, product)))
        k++;
    if (k == N_KNOWN)
        return false;
    *out = (struct dx_doctor_usb){.driver = known[k].driver, .name = known[k].name};
    snprintf(out->folder, sizeof(out->folder), "%s", folder);
    snprintf(out->port, sizeof(out->port), "%.31s", strrchr(folder, '/') + 1);
    snprintf(out->node, sizeof(out->node), "/dev/bus/usb/%03u/%03u", number(d, folder, "busnum"),
             number(d, folder, "devnum"));
    dx_doctor_read_at(d, folder, "serial", out->serial, sizeof(out->serial));
    return true;
}

unsigned dx_doctor_usb_devices(const struct dx_doctor *d, const char *driver,
                               struct dx_doctor_usb *out, unsigned max)
{
    static const char file[] = "/idVendor";
    struct dx_doctor_usb one;
    unsigned n = 0;
    glob_t g;

    dx_doctor_glob(d, "/sys/bus/usb/devices/*/idVendor", &g);
    for (size_t k = 0; k < g.gl_pathc && n < max; k++) {
        char folder[128];
        const char *path = dx_doctor_match(d, &g, k);

        snprintf(folder, sizeof(folder), "%.*s", (int)(strlen(path) - strlen(file)), path);
        if (describe_usb(d, &one, folder) && (!driver || !strcmp(driver, one.driver)))
            out[n++] = one;
    }
    globfree(&g);
    return n;
}

/* ---- permissions ------------------------------------------------------------------------------
 */

/* A node, whose it is, and whether a stream of the configuration reads it. */
struct node {
    const char *path, *name;
    bool is_needed;
};

static const char *make_mend(struct dx_doctor *d, const struct node *node, const struct stat *st,
                             const struct dx_doctor_user *user)
{
    const mode_t both = S_IRGRP | S_IWGRP;
    char group[64], rule[PATH_MAX];

    if ((st->st_mode & both) == both && st->st_gid != 0)
        return dx_doctor_command(
            d,
            user == &d->service || *d->pid ? "sudo adduser @ @ && sudo systemctl restart dexeld"
                                           : "sudo adduser @ @",
            user->name, dx_doctor_group_name(d, st->st_gid, group, sizeof(group)));
    return dx_doctor_command(
        d, dx_doctor_has_rule(d, rule, sizeof(rule)) ? TRIGGER : REINSTALL " && " TRIGGER,
        node->path);
}

/* Of whoever asks the kernel knows more than modes: a list of users, which udev has filled in. */
static bool may_open(const struct dx_doctor *d, const struct dx_doctor_user *user, const char *path,
                     const struct stat *st)
{
    return dx_doctor_may_open(user, st) ||
           (user == &d->me && !*d->root && faccessat(AT_FDCWD, path, R_OK | W_OK, AT_EACCESS) == 0);
}

static void look_at_node(struct dx_doctor *d, const struct node *node)
{
    const enum dx_doctor_level bad = node->is_needed ? DX_DOCTOR_PROBLEM : DX_DOCTOR_WARNING;
    const struct dx_doctor_user *user = dx_doctor_runs_as(d);
    char owner[160], group[64];
    struct stat st;

    if (!dx_doctor_stat(d, node->path, &st)) {
        dx_doctor_tell(d, bad, "sudo udevadm trigger --action=add",
                       "%s (%s) has no node, though the kernel knows the device", node->path,
                       node->name);
        return;
    }
    snprintf(owner, sizeof(owner), "%s (%.80s), group %s, mode %04o", node->path, node->name,
             dx_doctor_group_name(d, st.st_gid, group, sizeof(group)), st.st_mode & 07777);
    if (!may_open(d, user, node->path, &st)) {
        dx_doctor_tell(d, bad, make_mend(d, node, &st, user), "%s: %s may not open it", owner,
                       user->name);
    } else if (st.st_mode & S_IWOTH) {
        dx_doctor_tell(d, DX_DOCTOR_WARNING, dx_doctor_command(d, "sudo chmod o-rw @", node->path),
                       "%s: everybody may write to it", owner);
    } else if (user != &d->me && !may_open(d, &d->me, node->path, &st)) {
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s: %s may open it (and %s may not)", owner,
                       user->name, d->me.name);
    } else {
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "%s: %s may open it", owner, user->name);
    }
}

/* Each device of a class has a node of its name. */
static unsigned look_at_class(struct dx_doctor *d, const char *pattern, const char *what,
                              bool is_needed)
{
    unsigned n;
    glob_t g;

    dx_doctor_glob(d, pattern, &g);
    for (size_t k = 0; k < g.gl_pathc; k++) {
        const char *folder = dx_doctor_match(d, &g, k);
        char path[PATH_MAX], name[128];

        snprintf(path, sizeof(path), "/dev%.300s", strrchr(folder, '/'));
        if (!dx_doctor_read_at(d, folder, "name", name, sizeof(name)))
            snprintf(name, sizeof(name), "%s", what);
        look_at_node(d, &(struct node){path, name, is_needed});
    }
    n = (unsigned)g.gl_pathc;
    globfree(&g);
    return n;
}

static bool reads_ttys(const struct dx_doctor *d)
{
    for (uint32_t k = 0; k < d->config.n_streams; k++)
        if (!strcmp(d->config.streams[k].driver, "hokuyo") &&
            *d->config.streams[k].source.hokuyo.tty)
            return true;
    return false;
}

void dx_doctor_devices(struct dx_doctor *d)
{
    struct dx_doctor_usb usb[MAX_USB];
    unsigned n_usb = dx_doctor_usb_devices(d, NULL, usb, MAX_USB), n = n_usb;

    for (unsigned k = 0; k < n_usb; k++)
        look_at_node(
            d, &(struct node){usb[k].node, usb[k].name, dx_doctor_n_streams(d, usb[k].driver) > 0});
    n += look_at_class(d, "/sys/class/video4linux/video*", "camera",
                       dx_doctor_n_streams(d, "v4l2") > 0);
    n += look_at_class(d, "/sys/class/tty/ttyACM*", "serial port of USB", reads_ttys(d));
    if (dx_doctor_wants_gpio(d))
        n += look_at_class(d, "/sys/bus/gpio/devices/gpiochip*", "GPIO lines", true);
    if (n == 0)
        dx_doctor_tell(d, DX_DOCTOR_OK, NULL, "no device is attached that would have a node");
}
