/* CGAL's smoothing of unorganized points: cgal_smooth jet|bilateral POINTS.xyz OUT.xyz. Points keep
 * their order. Prints the line of cloud.hpp: seconds of smoothing, of normals before that. */
#include "cloud.hpp"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/bilateral_smooth_point_set.h>
#include <CGAL/jet_smooth_point_set.h>
#include <CGAL/pca_estimate_normals.h>
#include <CGAL/property_map.h>

#include <cstring>
#include <utility>

using Kernel = CGAL::Simple_cartesian<double>;
using Oriented = std::pair<Kernel::Point_3, Kernel::Vector_3>;

static const unsigned K = 24;

static double jet(std::vector<Oriented> &points)
{
    const double start = now_ms();

    CGAL::jet_smooth_point_set<CGAL::Sequential_tag>(
        points, K, CGAL::parameters::point_map(CGAL::First_of_pair_property_map<Oriented>()));
    return now_ms() - start;
}

/* Its weights look at the angle between normals; either side will do. */
static double bilateral(std::vector<Oriented> &points, double *normals_ms)
{
    const auto maps =
        CGAL::parameters::point_map(CGAL::First_of_pair_property_map<Oriented>())
            .normal_map(CGAL::Second_of_pair_property_map<Oriented>());
    double start = now_ms();

    CGAL::pca_estimate_normals<CGAL::Sequential_tag>(points, 18, maps);
    *normals_ms = now_ms() - start;
    start = now_ms();
    CGAL::bilateral_smooth_point_set<CGAL::Sequential_tag>(points, K, maps);
    return now_ms() - start;
}

int main(int argc, char **argv)
{
    if (argc != 4 || (std::strcmp(argv[1], "jet") && std::strcmp(argv[1], "bilateral"))) {
        std::fprintf(stderr, "usage: cgal_smooth jet|bilateral POINTS.xyz OUT.xyz\n");
        return 2;
    }
    std::vector<Oriented> points;
    double ms, normals_ms = 0;

    for (const Position &p : read_points(argv[2]))
        points.emplace_back(Kernel::Point_3(p[0], p[1], p[2]), Kernel::Vector_3(0, 0, 0));
    ms = std::strcmp(argv[1], "jet") == 0 ? jet(points) : bilateral(points, &normals_ms);
    FILE *f = std::fopen(argv[3], "w");

    if (!f) {
        std::perror(argv[3]);
        return 1;
    }
    for (const Oriented &p : points)
        std::fprintf(f, "%.17g %.17g %.17g\n", p.first.x(), p.first.y(), p.first.z());
    std::fclose(f);
    print_run(ms, normals_ms);
    return 0;
}
