/*
 * PCL's greedy projection (gp3) of unorganized points: pcl_greedy POINTS.xyz MESH.ply. With the
 * parameters of its tutorial, and a radius of 2.5 times the mean distance of the sixth neighbour;
 * normals of 20 neighbours, which are timed apart.
 */
#include "cloud.hpp"

#include <cmath>

#include <pcl/common/io.h>
#include <pcl/features/normal_3d.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/surface/gp3.h>

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using NormalCloud = pcl::PointCloud<pcl::PointNormal>;

/* Of some 500 samples. */
static double mean_sixth(const Cloud::Ptr &cloud)
{
    pcl::search::KdTree<pcl::PointXYZ> tree;
    pcl::Indices index;
    std::vector<float> distance2;
    double sum = 0;
    size_t n = 0;

    tree.setInputCloud(cloud);
    for (size_t k = 0; k < cloud->size(); k += cloud->size() / 500 + 1, n++) {
        tree.nearestKSearch(static_cast<pcl::index_t>(k), 7, index, distance2);
        sum += std::sqrt(distance2[6]);
    }
    return sum / static_cast<double>(n);
}

static void find_normals(NormalCloud &out, const Cloud::Ptr &cloud)
{
    pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
    pcl::PointCloud<pcl::Normal> normals;

    estimation.setInputCloud(cloud);
    estimation.setSearchMethod(pcl::search::KdTree<pcl::PointXYZ>::Ptr(
        new pcl::search::KdTree<pcl::PointXYZ>));
    estimation.setKSearch(20);
    estimation.compute(normals);
    pcl::concatenateFields(*cloud, normals, out);
}

static void mesh(pcl::PolygonMesh &out, const NormalCloud::Ptr &points, double radius)
{
    pcl::search::KdTree<pcl::PointNormal>::Ptr tree(new pcl::search::KdTree<pcl::PointNormal>);
    pcl::GreedyProjectionTriangulation<pcl::PointNormal> gp3;

    tree->setInputCloud(points);
    gp3.setSearchRadius(radius);
    gp3.setMu(2.5);
    gp3.setMaximumNearestNeighbors(100);
    gp3.setMaximumSurfaceAngle(M_PI / 4);
    gp3.setMinimumAngle(M_PI / 18);
    gp3.setMaximumAngle(2 * M_PI / 3);
    gp3.setNormalConsistency(false);
    gp3.setInputCloud(points);
    gp3.setSearchMethod(tree);
    gp3.reconstruct(out);
}

int main(int argc, char **argv)
{
    if (argc != 3) {
        std::fprintf(stderr, "usage: pcl_greedy POINTS.xyz MESH.ply\n");
        return 2;
    }
    const std::vector<Position> from = read_points(argv[1]);
    const Cloud::Ptr cloud(new Cloud);
    const NormalCloud::Ptr points(new NormalCloud);
    std::vector<Triangle> triangles;
    pcl::PolygonMesh out;

    for (const Position &p : from)
        cloud->push_back(pcl::PointXYZ(static_cast<float>(p[0]), static_cast<float>(p[1]),
                                       static_cast<float>(p[2])));
    const double radius = 2.5 * mean_sixth(cloud), start = work_ms();
    find_normals(*points, cloud);
    const double middle = work_ms();
    mesh(out, points, radius);
    const double end = work_ms();

    for (const pcl::Vertices &v : out.polygons)
        triangles.push_back({static_cast<uint32_t>(v.vertices[0]),
                             static_cast<uint32_t>(v.vertices[1]),
                             static_cast<uint32_t>(v.vertices[2])});
    print_run(end - middle, middle - start);
    write_ply(argv[2], from, triangles);
    return 0;
}
