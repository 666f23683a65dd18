/*
 * PCL's mesher for organized clouds, timed on a PCD file: what a user of ours would otherwise call.
 * Its mesh step alone, points ready in memory and the output vector used again, so that its
 * allocations are paid before the measured rounds. bench_peers.sh runs it.
 *
 * Output: a line "NAME MEDIAN_MS TRIANGLES BOUNDARY_EDGES" for each of the two ways, then
 * "peak_rss_mb N", read before the counting of edges.
 */
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <sys/resource.h>

#include <pcl/io/pcd_io.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/surface/organized_fast_mesh.h>
#include <pcl/surface/impl/organized_fast_mesh.hpp> /* built with our flags, not the package's */

using Point = pcl::PointXYZ;
using Mesher = pcl::OrganizedFastMesh<Point>;

struct Result {
    double median_ms;
    std::vector<pcl::Vertices> polygons;
};

static double now_ms()
{
    auto t = std::chrono::steady_clock::now().time_since_epoch();

    return std::chrono::duration<double, std::milli>(t).count();
}

static Result measure(Mesher &mesher, int n_rounds)
{
    Result r;
    std::vector<double> ms;

    mesher.reconstruct(r.polygons); /* warm: pages, caches, the output's memory */
    for (int k = 0; k < n_rounds; k++) {
        double start = now_ms();

        mesher.reconstruct(r.polygons);
        ms.push_back(now_ms() - start);
    }
    std::sort(ms.begin(), ms.end());
    r.median_ms = ms[ms.size() / 2];
    return r;
}

/* Like for like: the diagonal chosen by depth, edges up to 0.1 m, no test of the angle. */
static void limit_edges(Mesher &mesher)
{
    mesher.setTriangulationType(Mesher::TRIANGLE_ADAPTIVE_CUT);
    mesher.setMaxEdgeLength(0.1f);
    mesher.setAngleTolerance(-1);
}

/* Edges of one triangle only. */
static size_t count_boundary(const std::vector<pcl::Vertices> &polygons)
{
    std::vector<uint64_t> edge;
    size_t n = 0;

    for (const pcl::Vertices &p : polygons)
        for (size_t k = 0; k < 3; k++) {
            uint64_t a = static_cast<uint32_t>(p.vertices[k]);
            uint64_t b = static_cast<uint32_t>(p.vertices[(k + 1) % 3]);

            edge.push_back(std::min(a, b) << 32 | std::max(a, b));
        }
    std::sort(edge.begin(), edge.end());
    for (size_t k = 0, end; k < edge.size(); k = end) {
        for (end = k + 1; end < edge.size() && edge[end] == edge[k];)
            end++;
        n += end == k + 1;
    }
    return n;
}

static long peak_rss_mb()
{
    struct rusage u;

    getrusage(RUSAGE_SELF, &u);
    return u.ru_maxrss / 1024;
}

int main(int argc, char **argv)
{
    int n_rounds = argc > 2 ? std::atoi(argv[2]) : 3;
    pcl::PointCloud<Point>::Ptr cloud(new pcl::PointCloud<Point>);

    if (argc < 2 || n_rounds < 1) {
        std::fprintf(stderr, "usage: pcl_ofm SCAN.pcd [ROUNDS]\n");
        return 2;
    }
    if (pcl::io::loadPCDFile(argv[1], *cloud) < 0 || !cloud->isOrganized()) {
        std::fprintf(stderr, "pcl_ofm: %s: expected an organized point cloud\n", argv[1]);
        return 1;
    }

    Mesher limited, defaults;
    limited.setInputCloud(cloud);
    limit_edges(limited);
    defaults.setInputCloud(cloud); /* 12.5 degrees; triangles instead of quadrilaterals */
    defaults.setTriangulationType(Mesher::TRIANGLE_RIGHT_CUT);

    Result a = measure(limited, n_rounds);
    long rss = peak_rss_mb(); /* one output's memory */
    Result b = measure(defaults, n_rounds);

    std::printf("limited %.3f %zu %zu\n", a.median_ms, a.polygons.size(),
                count_boundary(a.polygons));
    std::printf("defaults %.3f %zu %zu\n", b.median_ms, b.polygons.size(),
                count_boundary(b.polygons));
    std::printf("peak_rss_mb %ld\n", rss);
    return 0;
}
