/*
 * Open3D's ball pivoting of unorganized points: o3d_pivot POINTS.xyz MESH.ply. Balls of 1.5, 3 and 6
 * times the mean distance of the nearest neighbour; normals of 20 neighbours, turned to one side
 * along tangent planes of 12, which are timed apart.
 */
#include "cloud.hpp"

#include <open3d/geometry/KDTreeSearchParam.h>
#include <open3d/geometry/PointCloud.h>
#include <open3d/geometry/TriangleMesh.h>

using namespace open3d::geometry;

static double mean_nearest(const PointCloud &cloud)
{
    double sum = 0;

    for (double x : cloud.ComputeNearestNeighborDistance())
        sum += x;
    return sum / static_cast<double>(cloud.points_.size());
}

int main(int argc, char **argv)
{
    if (argc != 3) {
        std::fprintf(stderr, "usage: o3d_pivot POINTS.xyz MESH.ply\n");
        return 2;
    }
    const std::vector<Position> from = read_points(argv[1]);
    std::vector<Triangle> triangles;
    PointCloud cloud;

    for (const Position &p : from)
        cloud.points_.emplace_back(p[0], p[1], p[2]);
    const double nearest = mean_nearest(cloud), start = work_ms();
    cloud.EstimateNormals(KDTreeSearchParamKNN(20));
    cloud.OrientNormalsConsistentTangentPlane(12);
    const double middle = work_ms();
    const auto mesh = TriangleMesh::CreateFromPointCloudBallPivoting(
        cloud, {1.5 * nearest, 3 * nearest, 6 * nearest});
    const double end = work_ms();

    for (const Eigen::Vector3i &t : mesh->triangles_)
        triangles.push_back({static_cast<uint32_t>(t[0]), static_cast<uint32_t>(t[1]),
                             static_cast<uint32_t>(t[2])});
    print_run(end - middle, middle - start);
    write_ply(argv[2], from, triangles);
    return 0;
}
