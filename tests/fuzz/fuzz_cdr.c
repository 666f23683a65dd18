/* PointCloud2 messages from outside: each value of each field lies in the message; and as frames.
 */
#include "drivers/file/format.h"
#include "drivers/file/ros_cloud.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t len)
{
    struct dx_xyz_frame frame = {0};
    struct dx_ros_cloud c;
    volatile double sum = 0;

    (void)dx_format_ros.decode(&frame, bytes, len, NULL);
    dx_xyz_frame_fini(&frame);
    if (dx_ros_cloud_get(&c, bytes, len) < 0)
        return 0;
    for (uint32_t k = 0; k < c.n_fields; k++)
        for (uint32_t row = 0; row < c.height && row < 100; row++)
            for (uint32_t col = 0; col < c.width && col < 100; col++)
                sum = sum + dx_ros_cloud_value(&c, &c.fields[k], row, col);
    return 0;
}
