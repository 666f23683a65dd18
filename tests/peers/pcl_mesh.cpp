/*
 * PCL's meshes of an organized PCD, as PLY: compare_scans.sh has them counted beside ours.
 *   PREFIX-adaptive.ply   adaptive cut, edges up to FACTOR times the 95th percentile of the
 *                         distances between neighbours of a row or column; no test of the angle
 *   PREFIX-defaults.ply   right cut and 12.5 degrees, as a new OrganizedFastMesh has them, but
 *                         triangles in place of quadrilaterals
 *
 * Output: "VALID FULL MAX_EDGE_M": points that are there, the triangles that all cells would give
 * (two of four points, one of three), the limit.
 */
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <pcl/io/pcd_io.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/surface/organized_fast_mesh.h>
#include <pcl/surface/impl/organized_fast_mesh.hpp> /* built with our flags, not the package's */

using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;
using Mesher = pcl::OrganizedFastMesh<Point>;

struct Scan {
    uint32_t valid, full;
    float max_edge_m;
};

/* Distances to the right and down, where both points are there. */
static std::vector<float> spacings(const Cloud &c)
{
    std::vector<float> d;

    for (uint32_t i = 0; i < c.height; i++)
        for (uint32_t j = 0; j < c.width; j++) {
            const Point &p = c.at(j, i);

            if (!pcl::isFinite(p))
                continue;
            if (j + 1 < c.width && pcl::isFinite(c.at(j + 1, i)))
                d.push_back((c.at(j + 1, i).getVector3fMap() - p.getVector3fMap()).norm());
            if (i + 1 < c.height && pcl::isFinite(c.at(j, i + 1)))
                d.push_back((c.at(j, i + 1).getVector3fMap() - p.getVector3fMap()).norm());
        }
    return d;
}

static Scan measure(const Cloud &c, float factor)
{
    std::vector<float> d = spacings(c);
    Scan s = {0, 0, 0};

    for (const Point &p : c)
        s.valid += pcl::isFinite(p);
    for (uint32_t i = 0; i + 1 < c.height; i++)
        for (uint32_t j = 0; j + 1 < c.width; j++) {
            int n = pcl::isFinite(c.at(j, i)) + pcl::isFinite(c.at(j + 1, i)) +
                    pcl::isFinite(c.at(j, i + 1)) + pcl::isFinite(c.at(j + 1, i + 1));

            s.full += n > 2 ? static_cast<uint32_t>(n - 2) : 0;
        }
    if (!d.empty()) {
        auto at = d.begin() + static_cast<std::ptrdiff_t>(d.size() * 95 / 100);

        std::nth_element(d.begin(), at, d.end());
        s.max_edge_m = factor * *at;
    }
    return s;
}

static bool write_ply(const std::string &path, const Cloud &c,
                      const std::vector<pcl::Vertices> &polygons)
{
    std::FILE *f = std::fopen(path.c_str(), "wb");

    if (!f)
        return false;
    std::fprintf(f,
                 "ply\nformat binary_little_endian 1.0\nelement vertex %zu\nproperty float x\n"
                 "property float y\nproperty float z\nelement face %zu\n"
                 "property list uchar int vertex_indices\nend_header\n",
                 c.size(), polygons.size());
    for (const Point &p : c) { /* no triangle uses those that are not there */
        float xyz[3] = {p.x, p.y, p.z};

        for (float &v : xyz)
            v = std::isfinite(v) ? v : 0;
        std::fwrite(xyz, 4, 3, f);
    }
    for (const pcl::Vertices &p : polygons) {
        std::fputc(3, f);
        for (int k = 0; k < 3; k++) {
            int32_t v = static_cast<int32_t>(p.vertices[k]);

            std::fwrite(&v, 4, 1, f);
        }
    }
    bool ok = !std::ferror(f);
    return std::fclose(f) == 0 && ok;
}

static bool mesh(Mesher &mesher, const Cloud::Ptr &cloud, const std::string &path)
{
    std::vector<pcl::Vertices> polygons;

    mesher.setInputCloud(cloud);
    mesher.reconstruct(polygons);
    if (write_ply(path, *cloud, polygons))
        return true;
    std::fprintf(stderr, "pcl_mesh: %s: could not be written\n", path.c_str());
    return false;
}

int main(int argc, char **argv)
{
    float factor = argc == 4 ? static_cast<float>(std::atof(argv[3])) : 0;
    Cloud::Ptr cloud(new Cloud);

    if (!(factor > 0)) {
        std::fprintf(stderr, "usage: pcl_mesh SCAN.pcd PREFIX FACTOR\n");
        return 2;
    }
    if (pcl::io::loadPCDFile(argv[1], *cloud) < 0 || !cloud->isOrganized()) {
        std::fprintf(stderr, "pcl_mesh: %s: expected an organized point cloud\n", argv[1]);
        return 1;
    }

    Scan s = measure(*cloud, factor);
    std::string prefix = argv[2];
    Mesher adaptive, defaults;

    adaptive.setTriangulationType(Mesher::TRIANGLE_ADAPTIVE_CUT);
    adaptive.setMaxEdgeLength(s.max_edge_m); /* where it is set the angle is not asked */
    defaults.setTriangulationType(Mesher::TRIANGLE_RIGHT_CUT);
    if (!mesh(adaptive, cloud, prefix + "-adaptive.ply") ||
        !mesh(defaults, cloud, prefix + "-defaults.ply"))
        return 1;
    std::printf("%u %u %.4f\n", s.valid, s.full, static_cast<double>(s.max_edge_m));
    return 0;
}
