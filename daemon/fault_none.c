/* No faults. */
#include "daemon/fault.h"

void dx_fault_point(enum dx_fault_place place)
{
    (void)place;
}
