/* sanitized: status 1 in a build with a sanitizer. */
#include "tests/system/follower.h"

int main(void)
{
    return SANITIZED;
}
