/*
 * A mesh cut into parts that each fit into a message: some of its triangles, with the vertices that
 * they use. Owned by one thread.
 */
#ifndef DX_ROS_PART_H
#define DX_ROS_PART_H

#include "tools/mesh.h"

struct dx_ros_part {
    uint32_t max_vertices, max_indices;
    float *xyz;      /* [n_vertices][3] */
    uint32_t *index; /* [n_indices], into xyz */
    uint32_t n_vertices, n_indices;
    uint32_t *map; /* of the mesh's vertices: `base` and more, those of this part */
    uint32_t base, map_cap;
};

/* Room for so many vertices and twice as many triangles, of which one at least fits. -ENOMEM. */
int dx_ros_part_new(struct dx_ros_part **out, uint32_t max_vertices);
void dx_ros_part_free(struct dx_ros_part *p);

/* Before the parts of a mesh. -ENOMEM. */
int dx_ros_part_begin(struct dx_ros_part *p, const struct dx_mesh *mesh);
/* The part that begins with triangle `first`; returns the first triangle of the next. */
uint32_t dx_ros_part_next(struct dx_ros_part *p, const struct dx_mesh *mesh, uint32_t first);

#endif
