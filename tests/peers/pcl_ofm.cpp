/*
 * PCL's mesher for organized clouds, timed on a PCD file: what a user of ours would otherwise call.
 * Its mesh step alone, points ready in memory and the output vector used again, so that its
 * allocations are paid before the measured rounds. bench_peers.sh runs it; its lines are
 * peer.hpp's, the memory that of the first way.
 */
#include "peer.hpp"

#include <cstdlib>

#include <pcl/io/pcd_io.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/surface/organized_fast_mesh.h>
#include <pcl/surface/impl/organized_fast_mesh.hpp> /* built with our flags, not the package's */

using Point = pcl::PointXYZ;
using Mesher = pcl::OrganizedFastMesh<Point>;
using Polygons = std::vector<pcl::Vertices>;

/* Like for like: the diagonal chosen by depth, edges up to 0.1 m, no test of the angle. */
static void limit_edges(Mesher &mesher)
{
    mesher.setTriangulationType(Mesher::TRIANGLE_ADAPTIVE_CUT);
    mesher.setMaxEdgeLength(0.1f);
    mesher.setAngleTolerance(-1);
}

/* 12.5 degrees; triangles instead of quadrilaterals. */
static void set_defaults(Mesher &mesher)
{
    mesher.setTriangulationType(Mesher::TRIANGLE_RIGHT_CUT);
}

static void print_polygons(const char *name, double ms, const Polygons &polygons)
{
    Edges edges;

    for (const pcl::Vertices &p : polygons)
        edges.add_triangle(static_cast<uint32_t>(p.vertices[0]),
                           static_cast<uint32_t>(p.vertices[1]),
                           static_cast<uint32_t>(p.vertices[2]));
    print_way(name, ms, edges);
}

int main(int argc, char **argv)
{
    int n_rounds = argc > 2 ? std::atoi(argv[2]) : 3;
    bool limited_alone = argc > 3 && std::string(argv[3]) == "limited";
    pcl::PointCloud<Point>::Ptr cloud(new pcl::PointCloud<Point>);

    if (argc < 2 || n_rounds < 1) {
        std::fprintf(stderr, "usage: pcl_ofm SCAN.pcd [ROUNDS [limited]]\n");
        return 2;
    }
    if (pcl::io::loadPCDFile(argv[1], *cloud) < 0 || !cloud->isOrganized()) {
        std::fprintf(stderr, "pcl_ofm: %s: expected an organized point cloud\n", argv[1]);
        return 1;
    }

    Mesher mesher;
    Polygons polygons;
    mesher.setInputCloud(cloud);
    limit_edges(mesher);
    double ms = median_ms(n_rounds, [&] { mesher.reconstruct(polygons); });
    long rss = peak_rss_mb();
    if (limited_alone) { /* of a scan so large that its edges are not counted */
        std::printf("limited %.3f %zu -\n", ms, polygons.size());
    } else {
        print_polygons("limited", ms, polygons);

        Mesher defaults;
        defaults.setInputCloud(cloud);
        set_defaults(defaults);
        ms = median_ms(n_rounds, [&] { defaults.reconstruct(polygons); });
        print_polygons("defaults", ms, polygons);
    }
    std::printf("peak_rss_mb %ld\n", rss);
    return 0;
}
