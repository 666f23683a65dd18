/* The drivers of this build. */
#include "drivers/driver.h"

#include "drivers/file/file.h"
#include "drivers/hokuyo/hokuyo.h"
#include "drivers/kinect/kinect.h"
#include "drivers/synth/synth.h"
#include "drivers/v4l2/v4l2.h"

#include <string.h>

const struct dx_driver *const dx_drivers[] = {&dx_file_driver,   &dx_synth_driver,  &dx_v4l2_driver,
                                              &dx_hokuyo_driver, &dx_kinect_driver, NULL};

const struct dx_driver *dx_driver_find(const char *name)
{
    for (size_t k = 0; dx_drivers[k]; k++)
        if (strcmp(dx_drivers[k]->name, name) == 0)
            return dx_drivers[k];
    return NULL;
}
