/*
 * sandbox_probe OUT: what its process may do, one line each, into the file OUT: device nodes that
 * it can open, folders that it can write in, files that it can read, families of sockets, system
 * calls that are not refused. A test runs it within a unit's sandbox and holds the lines to a list.
 * Nothing that it tries changes anything.
 */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <sys/personality.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

static FILE *out;

static void try_device(const char *path)
{
    int fd = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);

    /* the node is let through when its driver is what refuses: no such device, busy */
    if (fd < 0 && (errno == EPERM || errno == EACCES || errno == ENOENT))
        return;
    fprintf(out, "device %s\n", path);
    if (fd >= 0)
        close(fd);
}

static int by_name(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

/* Every character and block device below a folder. */
static void try_devices(const char *folder)
{
    struct dirent **entries;
    int n = scandir(folder, &entries, NULL, by_name);

    for (int k = 0; k < n; k++) {
        const char *name = entries[k]->d_name;
        char path[512];
        struct stat st;

        snprintf(path, sizeof(path), "%s/%s", folder, name);
        if (*name != '.' && lstat(path, &st) == 0) {
            if (S_ISDIR(st.st_mode))
                try_devices(path);
            else if (S_ISCHR(st.st_mode) || S_ISBLK(st.st_mode))
                try_device(path);
        }
        free(entries[k]);
    }
    if (n >= 0)
        free(entries);
}

static void try_folders(void)
{
    static const char *const folders[] = {"/",
                                          "/boot",
                                          "/dev",
                                          "/dev/mqueue",
                                          "/dev/shm",
                                          "/etc",
                                          "/etc/dexeld",
                                          "/home",
                                          "/opt",
                                          "/root",
                                          "/run",
                                          "/run/dexeld",
                                          "/run/dexeld-metrics",
                                          "/run/lock",
                                          "/srv",
                                          "/sys/fs/cgroup",
                                          "/tmp",
                                          "/usr",
                                          "/var",
                                          "/var/cache",
                                          "/var/lib",
                                          "/var/lib/dexeld",
                                          "/var/log",
                                          "/var/tmp"};

    for (size_t k = 0; k < sizeof(folders) / sizeof(*folders); k++) {
        char path[128];
        int fd;

        snprintf(path, sizeof(path), "%s/hil-probe", folders[k]);
        fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
        if (fd < 0)
            continue;
        fprintf(out, "write %s\n", folders[k]);
        close(fd);
        unlink(path);
    }
}

/* Of others, of the kernel, and the file that the test has laid in the machine's /tmp. */
static void try_files(void)
{
    static const char *const files[] = {"/etc/shadow",
                                        "/etc/dexeld/dexeld.yaml",
                                        "/proc/1/cmdline",
                                        "/proc/cmdline",
                                        "/proc/kallsyms",
                                        "/proc/kmsg",
                                        "/proc/sys/kernel/hostname",
                                        "/root/hil-marker",
                                        "/sys/kernel/debug",
                                        "/tmp/hil-marker"};

    for (size_t k = 0; k < sizeof(files) / sizeof(*files); k++) {
        int fd = open(files[k], O_RDONLY | O_NONBLOCK | O_CLOEXEC);

        if (fd < 0)
            continue;
        fprintf(out, "read %s\n", files[k]);
        close(fd);
    }
}

static void try_sockets(void)
{
    static const struct {
        const char *name;
        int family, type;
    } sockets[] = {{"inet", AF_INET, SOCK_STREAM},         {"inet6", AF_INET6, SOCK_STREAM},
                   {"inet datagram", AF_INET, SOCK_DGRAM}, {"netlink", AF_NETLINK, SOCK_RAW},
                   {"packet", AF_PACKET, SOCK_RAW},        {"unix", AF_UNIX, SOCK_STREAM}};

    for (size_t k = 0; k < sizeof(sockets) / sizeof(*sockets); k++) {
        int fd = socket(sockets[k].family, sockets[k].type | SOCK_CLOEXEC, 0);

        if (fd < 0)
            continue;
        fprintf(out, "socket %s\n", sockets[k].name);
        close(fd);
    }
}

static long call_mmap(void)
{
    void *p =
        mmap(NULL, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);

    return p == MAP_FAILED ? -1 : 0;
}

static long call_mprotect(void)
{
    void *p = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);

    return p == MAP_FAILED ? -1 : mprotect(p, 4096, PROT_READ | PROT_EXEC);
}

static long call_setuid_file(void)
{
    char path[] = "/var/lib/dexeld/hil-probe-XXXXXX";
    int fd = mkstemp(path), r, why;

    if (fd < 0)
        return -1;
    r = fchmod(fd, 04700);
    why = errno;
    close(fd);
    unlink(path);
    errno = why;
    return r;
}

static long call_scheduler(void)
{
    const struct sched_param p = {.sched_priority = 1};

    return sched_setscheduler(0, SCHED_FIFO, &p);
}

static long call_priority(void)
{
    return setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0));
}

/* With arguments that are wrong: what comes back is EPERM only from who refuses the call itself. */
static long call_mount(void)
{
    return mount("none", "/nowhere", "none", 0, NULL);
}
static long call_umount(void)
{
    return umount2("/nowhere", 0);
}
static long call_user_ns(void)
{
    return unshare(CLONE_NEWUSER | 1);
}
static long call_bpf(void)
{
    return syscall(SYS_bpf, -1, NULL, 0);
}
static long call_module(void)
{
    return syscall(SYS_finit_module, -1, "", 0);
}
static long call_ptrace(void)
{
    return ptrace(PTRACE_PEEKDATA, 0, NULL, NULL);
}
static long call_personality(void)
{
    return personality(PER_LINUX32) < 0 ? -1 : personality(0);
}
static long call_time(void)
{
    return syscall(SYS_clock_settime, 0, NULL);
}
static long call_hostname(void)
{
    return syscall(SYS_sethostname, "", -1);
}
static long call_chroot(void)
{
    return chroot("/nowhere");
}
static long call_swap(void)
{
    return syscall(SYS_swapon, NULL, 0);
}
static long call_keys(void)
{
    return syscall(SYS_keyctl, -1, 0, 0, 0, 0);
}
static long call_perf(void)
{
    return syscall(SYS_perf_event_open, NULL, 0, -1, -1, 0);
}
static long call_chown(void)
{
    return chown("/nowhere", 0, 0);
}

static void try_calls(void)
{
    static const struct {
        const char *name;
        long (*call)(void);
    } calls[] = {{"bpf", call_bpf},
                 {"chown", call_chown},
                 {"chroot", call_chroot},
                 {"clock_settime", call_time},
                 {"executable memory", call_mmap},
                 {"executable memory, written before", call_mprotect},
                 {"file with setuid", call_setuid_file},
                 {"finit_module", call_module},
                 {"keyctl", call_keys},
                 {"mount", call_mount},
                 {"perf_event_open", call_perf},
                 {"personality", call_personality},
                 {"ptrace", call_ptrace},
                 {"real-time priority", call_scheduler},
                 {"sethostname", call_hostname},
                 {"setpriority", call_priority},
                 {"swapon", call_swap},
                 {"umount", call_umount},
                 {"user namespace", call_user_ns}};

    for (size_t k = 0; k < sizeof(calls) / sizeof(*calls); k++) {
        errno = 0;
        if (calls[k].call() >= 0 || (errno != EPERM && errno != EACCES))
            fprintf(out, "call %s\n", calls[k].name);
    }
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: sandbox_probe OUT\n");
        return 2;
    }
    out = fopen(argv[1], "w");
    if (!out) {
        perror(argv[1]);
        return 1;
    }
    try_devices("/dev");
    try_folders();
    try_files();
    try_sockets();
    try_calls();
    return fclose(out) ? 1 : 0;
}
