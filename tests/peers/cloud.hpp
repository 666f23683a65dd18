/*
 * What the programs that mesh unorganized points share: points of a file of lines of x y z, the
 * mesh as PLY for `dexel mesh --report`, and the line of figures that bench_peers_clouds.sh reads:
 * "MESH_SECONDS NORMALS_SECONDS PEAK_RSS_MB". One run a process, nothing warmed, as dexel's own.
 */
#ifndef CLOUD_HPP
#define CLOUD_HPP

#include "peer.hpp"

#include <array>
#include <cstdlib>
#include <ctime>

using Position = std::array<double, 3>;
using Triangle = std::array<uint32_t, 3>;

static inline std::vector<Position> read_points(const char *path)
{
    std::vector<Position> points;
    FILE *f = std::fopen(path, "r");
    Position p;

    if (!f) {
        std::perror(path);
        std::exit(1);
    }
    while (std::fscanf(f, "%lf %lf %lf", &p[0], &p[1], &p[2]) == 3)
        points.push_back(p);
    std::fclose(f);
    return points;
}

/* Little-endian machines only, as PCL's and CGAL's packages are. */
static inline void write_ply(const char *path, const std::vector<Position> &points,
                             const std::vector<Triangle> &triangles)
{
    FILE *f = std::fopen(path, "wb");

    if (!f) {
        std::perror(path);
        std::exit(1);
    }
    std::fprintf(f,
                 "ply\nformat binary_little_endian 1.0\nelement vertex %zu\nproperty double x\n"
                 "property double y\nproperty double z\nelement face %zu\n"
                 "property list uchar uint vertex_indices\nend_header\n",
                 points.size(), triangles.size());
    std::fwrite(points.data(), sizeof(Position), points.size(), f);
    for (const Triangle &t : triangles) {
        std::fputc(3, f);
        std::fwrite(t.data(), sizeof(t), 1, f);
    }
    if (std::fclose(f) != 0) {
        std::perror(path);
        std::exit(1);
    }
}

/* What all threads of this process have worked: others on the machine disturb it less than the time
 * of day, and on one processor it is no more than that. */
static inline double work_ms()
{
    timespec t;

    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

static inline void print_run(double mesh_ms, double normals_ms)
{
    std::printf("%.6f %.6f %ld\n", mesh_ms / 1e3, normals_ms / 1e3, peak_rss_mb());
}

#endif
