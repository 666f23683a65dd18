/* CGAL's advancing front of unorganized points: cgal_front POINTS.xyz MESH.ply */
#include "cloud.hpp"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <iterator>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

int main(int argc, char **argv)
{
    if (argc != 3) {
        std::fprintf(stderr, "usage: cgal_front POINTS.xyz MESH.ply\n");
        return 2;
    }
    const std::vector<Position> from = read_points(argv[1]);
    std::vector<Kernel::Point_3> points;
    std::vector<std::array<std::size_t, 3>> facets;
    std::vector<Triangle> triangles;

    for (const Position &p : from)
        points.emplace_back(p[0], p[1], p[2]);
    const double start = work_ms();
    CGAL::advancing_front_surface_reconstruction(points.begin(), points.end(),
                                                 std::back_inserter(facets));
    const double ms = work_ms() - start;

    for (const auto &f : facets)
        triangles.push_back({static_cast<uint32_t>(f[0]), static_cast<uint32_t>(f[1]),
                             static_cast<uint32_t>(f[2])});
    print_run(ms, 0);
    write_ply(argv[2], from, triangles);
    return 0;
}
