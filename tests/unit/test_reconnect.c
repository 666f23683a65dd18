/*
 * libdexel where another connection is to mend things (dexel_options.reconnect), against a service
 * that answers and does not serve: full, or gone as soon as it has said who it is.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/unit/client_fixture.h"

#include "client/session.h"

#define N_TRIES 4 /* at once, then after 0.1, 0.2 and 0.4 s */

/* Dispatches until the client comes; its connection. */
static int await_client(struct dexel *d, int listener)
{
    struct pollfd p[] = {{.fd = dexel_fd(d), .events = POLLIN}, {.fd = listener, .events = POLLIN}};

    while (!(p[1].revents & POLLIN)) {
        assert_true(poll(p, 2, 300000) > 0);
        if (p[0].revents)
            assert_int_equal(dexel_dispatch(d), 0);
    }
    return accept4(listener, NULL, NULL, SOCK_CLOEXEC);
}

static void await_loss(struct dexel *d)
{
    struct pollfd p = {.fd = dexel_fd(d), .events = POLLIN};

    while (d->connection.fd >= 0) {
        assert_int_equal(poll(&p, 1, 300000), 1);
        assert_int_equal(dexel_dispatch(d), 0);
    }
}

/* Each try takes longer to come, and that there is no service is told once, with the reason. */
static void expect_rarer_tries(const struct script *said, const char *reason)
{
    struct sockaddr_un addr = {.sun_family = AF_UNIX};
    char dir[] = "/tmp/dexel-test-XXXXXX";
    struct dexel_options options = {.socket = addr.sun_path, .reconnect = 1};
    struct seen seen = {0};
    struct dexel *d;
    int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);

    assert_non_null(mkdtemp(dir));
    snprintf(addr.sun_path, sizeof(addr.sun_path), "%s/s", dir);
    assert_int_equal(bind(listener, (struct sockaddr *)&addr, sizeof(addr)), 0);
    assert_int_equal(listen(listener, 1), 0);
    assert_int_equal(dexel_open(&d, &options, &callbacks, &seen), 0);
    for (uint32_t k = 0; k < N_TRIES; k++) {
        int fd = await_client(d, listener);

        assert_int_equal(d->again.n_tries, k + 1);
        assert_int_equal(send(fd, said->bytes, said->len, MSG_NOSIGNAL), said->len);
        close(fd);
        await_loss(d);
    }
    assert_int_equal(seen.n_state, 1);
    assert_int_equal(seen.state, DEXEL_GONE);
    assert_non_null(strstr(seen.text, reason));
    assert_int_equal(seen.n_reset, 0); /* nothing is held that could be void */
    dexel_close(d);
    close(listener);
    unlink(addr.sun_path);
    rmdir(dir);
}

static void a_full_service_is_not_stormed(void **state)
{
    struct script said = {0};

    (void)state;
    script_welcome(&said);
    script_error(&said, DX_WIRE_E_LIMIT, "no memory for one more (client_memory_mib)");
    expect_rarer_tries(&said, "client_memory_mib");
    free(said.bytes);
}

static void a_service_that_falls_over_is_not_stormed(void **state)
{
    struct script said = {0};

    (void)state;
    script_welcome(&said);
    expect_rarer_tries(&said, "closed the connection");
    free(said.bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_full_service_is_not_stormed),
        cmocka_unit_test(a_service_that_falls_over_is_not_stormed),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
