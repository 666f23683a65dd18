/* PointCloud2 messages from outside: each value of each field lies in the message. */
#include "drivers/file/ros_cloud.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    struct dx_ros_cloud c;
    volatile double sum = 0;

    if (dx_ros_cloud_get(&c, bytes, len) < 0)
        return 0;
    for (uint32_t k = 0; k < c.n_fields; k++)
        for (uint32_t row = 0; row < c.height && row < 100; row++)
            for (uint32_t col = 0; col < c.width && col < 100; col++)
                sum = sum + dx_ros_cloud_value(&c, &c.fields[k], row, col);
    return 0;
}
