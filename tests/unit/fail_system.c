/* Wrapped functions of the system: count, fail the call that was asked for, else call the real
 * ones. */
#include "tests/unit/fail_system.h"

#include <dirent.h>
#include <errno.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <sys/socket.h>
#include <sys/types.h>

static atomic_uint_fast64_t left; /* calls until the one that fails */
static atomic_int failed;         /* the error of it; 0: not yet */

int __real_open(const char *path, int flags, mode_t mode);
int __real_eventfd(unsigned count, int flags);
int __real_socket(int domain, int type, int protocol);
int __real_listen(int fd, int backlog);
int __real_accept4(int fd, struct sockaddr *from, socklen_t *len, int flags);
DIR *__real_opendir(const char *path);
FILE *__real_open_memstream(char **text, size_t *len);
int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attr, void *(*start)(void *),
                          void *arg);
int __wrap_open(const char *path, int flags, ...);
int __wrap_eventfd(unsigned count, int flags);
int __wrap_socket(int domain, int type, int protocol);
int __wrap_listen(int fd, int backlog);
int __wrap_accept4(int fd, struct sockaddr *from, socklen_t *len, int flags);
DIR *__wrap_opendir(const char *path);
FILE *__wrap_open_memstream(char **text, size_t *len);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attr, void *(*start)(void *),
                          void *arg);

static bool fails(int error)
{
    uint64_t n = atomic_load(&left);

    while (n && !atomic_compare_exchange_weak(&left, &n, n - 1))
        ;
    if (n != 1)
        return false;
    atomic_store(&failed, error);
    errno = error;
    return true;
}

void fail_system_arm(uint64_t n)
{
    atomic_store(&failed, 0);
    atomic_store(&left, n);
}

bool fail_system_has_failed(void)
{
    return atomic_load(&failed) != 0;
}

int fail_system_why(void)
{
    return atomic_load(&failed);
}

int __wrap_open(const char *path, int flags, ...)
{
    va_list args;
    mode_t mode;

    va_start(args, flags);
    mode = va_arg(args, mode_t);
    va_end(args);
    return fails(EMFILE) ? -1 : __real_open(path, flags, mode);
}

int __wrap_eventfd(unsigned count, int flags)
{
    return fails(EMFILE) ? -1 : __real_eventfd(count, flags);
}

int __wrap_socket(int domain, int type, int protocol)
{
    return fails(EMFILE) ? -1 : __real_socket(domain, type, protocol);
}

int __wrap_listen(int fd, int backlog)
{
    return fails(ENOBUFS) ? -1 : __real_listen(fd, backlog);
}

int __wrap_accept4(int fd, struct sockaddr *from, socklen_t *len, int flags)
{
    return fails(EMFILE) ? -1 : __real_accept4(fd, from, len, flags);
}

DIR *__wrap_opendir(const char *path)
{
    return fails(EMFILE) ? NULL : __real_opendir(path);
}

FILE *__wrap_open_memstream(char **text, size_t *len)
{
    return fails(ENOMEM) ? NULL : __real_open_memstream(text, len);
}

int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attr, void *(*start)(void *),
                          void *arg)
{
    return fails(EAGAIN) ? EAGAIN : __real_pthread_create(thread, attr, start, arg);
}
