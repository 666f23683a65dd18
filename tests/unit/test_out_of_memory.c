/* A service for which an allocation fails, each in turn: service_child.h. */
#include "tests/unit/service_child.h"

#include "tests/unit/fail_alloc.h"

static const char *const requests[] = {"{\"request\":\"status\"}\n", NULL};
static const struct failing_calls allocations = {fail_alloc_arm, fail_alloc_has_failed, NULL, false,
                                                 requests};

static void each_call_may_fail(void **state)
{
    assert_in_range(fail_each_call(*state), 100, MOST_CALLS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate_setup_teardown(each_call_may_fail, make_place, remove_place,
                                                 (void *)&allocations),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
