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

/* A socket, and a client that is to be served there. */
struct place {
    char dir[32];
    struct sockaddr_un addr;
    int listener;
    struct dexel *d;
    struct seen seen;
};

static void place_open(struct place *p)
{
    struct dexel_options options = {.socket = p->addr.sun_path, .reconnect = 1};

    *p = (struct place){.dir = "/tmp/dexel-test-XXXXXX", .addr = {.sun_family = AF_UNIX}};
    p->listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_non_null(mkdtemp(p->dir));
    snprintf(p->addr.sun_path, sizeof(p->addr.sun_path), "%s/s", p->dir);
    assert_int_equal(bind(p->listener, (struct sockaddr *)&p->addr, sizeof(p->addr)), 0);
    assert_int_equal(listen(p->listener, 1), 0);
    assert_int_equal(dexel_open(&p->d, &options, &callbacks, &p->seen), 0);
}

static void place_close(struct place *p)
{
    dexel_close(p->d);
    close(p->listener);
    unlink(p->addr.sun_path);
    rmdir(p->dir);
}

/* Dispatches until the client comes; its connection. */
static int await_client(struct place *at)
{
    struct pollfd p[] = {{.fd = dexel_fd(at->d), .events = POLLIN},
                         {.fd = at->listener, .events = POLLIN}};

    while (!(p[1].revents & POLLIN)) {
        assert_true(poll(p, 2, 300000) > 0);
        if (p[0].revents)
            assert_int_equal(dexel_dispatch(at->d), 0);
    }
    return accept4(at->listener, NULL, NULL, SOCK_CLOEXEC);
}

static void await_loss(struct dexel *d)
{
    struct pollfd p = {.fd = dexel_fd(d), .events = POLLIN};

    while (d->connection.fd >= 0) {
        assert_int_equal(poll(&p, 1, 300000), 1);
        assert_int_equal(dexel_dispatch(d), 0);
    }
}

/* A service that says this to the next try, and goes. */
static void serve(struct place *at, const struct script *said)
{
    int fd = await_client(at);

    assert_int_equal(send(fd, said->bytes, said->len, MSG_NOSIGNAL), said->len);
    close(fd);
    await_loss(at->d);
}

/* Each try takes longer to come, and that there is no service is told once, with the reason. */
static void expect_rarer_tries(const struct script *said, const char *reason)
{
    struct place p;

    place_open(&p);
    for (uint32_t k = 0; k < N_TRIES; k++) {
        serve(&p, said);
        assert_int_equal(p.d->again.n_tries, k + 2); /* the next one is due */
    }
    assert_int_equal(p.seen.n_state, 1);
    assert_int_equal(p.seen.state, DEXEL_GONE);
    assert_non_null(strstr(p.seen.text, reason));
    assert_int_equal(p.seen.n_reset, 0); /* nothing is held that could be void */
    place_close(&p);
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

/* A service that told a state is gone anew when it goes, also one that had not served yet. */
static void a_state_is_not_the_last_word(void **state)
{
    struct script said = {0};
    struct place p;

    (void)state;
    script_welcome(&said);
    script_state(&said, DX_STREAM_OPENING, "a device");
    place_open(&p);
    for (int k = 1; k <= 2; k++) {
        serve(&p, &said);
        assert_int_equal(p.seen.n_state, 2 * k); /* opening, gone */
        assert_int_equal(p.seen.state, DEXEL_GONE);
    }
    place_close(&p);
    free(said.bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_full_service_is_not_stormed),
        cmocka_unit_test(a_service_that_falls_over_is_not_stormed),
        cmocka_unit_test(a_state_is_not_the_last_word),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
