/* sanitized: status 1 in a build with a sanitizer or that counts lines, which is many times slower.
 */
#include "tests/system/follower.h"

int main(void)
{
    return SANITIZED;
}
