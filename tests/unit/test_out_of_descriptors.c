/* A service for which the system has no descriptor or no thread, at each call in turn:
 * service_child.h. */
#include "tests/unit/service_child.h"

#include "tests/unit/fail_system.h"

static const char *const requests[] = {"{\"request\":\"status\"}\n",  "{\"request\":\"metrics\"}\n",
                                       "{\"request\":\"devices\"}\n", "{\"request\":\"config\"}\n",
                                       "{\"request\":\"reload\"}\n",  NULL};
static const struct failing_calls calls = {fail_system_arm, fail_system_has_failed, fail_system_why,
                                           true, requests};

static void each_call_may_fail(void **state)
{
    assert_in_range(fail_each_call(*state), 20, MOST_CALLS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate_setup_teardown(each_call_may_fail, make_place, remove_place,
                                                 (void *)&calls),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
