/*
 * VTK on an organized scan, timed: a structured grid with the missing points blanked, its surface
 * by the filter made for such grids, and that as triangles. VTK has no rule for edges; so a second
 * way blanks besides, in the measured time, the cells with a side of more than 0.1 m, as its users
 * must themselves, and takes the general filter: the other one looks at blanked points alone (9.1).
 * Points are ready in memory. bench_peers.sh runs it; its lines are peer.hpp's, the memory that of
 * the first way.
 */
#include "peer.hpp"

#include <cmath>
#include <cstdlib>

#include <pcl/io/pcd_io.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkGeometryFilter.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStructuredGrid.h>
#include <vtkStructuredGridGeometryFilter.h>
#include <vtkTriangleFilter.h>

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

#define LIMIT_M 0.1f

static bool is_missing(const pcl::PointXYZ &p)
{
    return !std::isfinite(p.x) || (p.x == 0 && p.y == 0 && p.z == 0);
}

static bool is_long(const pcl::PointXYZ &a, const pcl::PointXYZ &b)
{
    float x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;

    return x * x + y * y + z * z > LIMIT_M * LIMIT_M;
}

static void set_points(vtkStructuredGrid *grid, const Cloud &cloud)
{
    vtkNew<vtkFloatArray> xyz;
    vtkNew<vtkPoints> points;

    xyz->SetNumberOfComponents(3);
    xyz->SetNumberOfTuples(static_cast<vtkIdType>(cloud.size()));
    for (size_t k = 0; k < cloud.size(); k++)
        xyz->SetTuple3(static_cast<vtkIdType>(k), cloud[k].x, cloud[k].y, cloud[k].z);
    points->SetData(xyz);
    grid->SetDimensions(static_cast<int>(cloud.width), static_cast<int>(cloud.height), 1);
    grid->SetPoints(points);
}

static void blank_missing(vtkStructuredGrid *grid, const Cloud &cloud)
{
    for (size_t k = 0; k < cloud.size(); k++)
        if (is_missing(cloud[k]))
            grid->BlankPoint(static_cast<vtkIdType>(k));
}

static void blank_long(vtkStructuredGrid *grid, const Cloud &cloud)
{
    vtkIdType cell = 0;

    for (uint32_t i = 0; i + 1 < cloud.height; i++)
        for (uint32_t j = 0; j + 1 < cloud.width; j++, cell++) {
            const pcl::PointXYZ &a = cloud(j, i), &b = cloud(j + 1, i);
            const pcl::PointXYZ &d = cloud(j, i + 1), &c = cloud(j + 1, i + 1);

            if (is_long(a, b) || is_long(b, c) || is_long(c, d) || is_long(d, a))
                grid->BlankCell(cell);
        }
}

template <class Surface>
static void measure(const char *name, const Cloud &cloud, int n_rounds, bool limited, long *rss)
{
    vtkNew<Surface> surface;
    vtkNew<vtkTriangleFilter> triangles;
    vtkNew<vtkStructuredGrid> grid;
    const vtkIdType *id;
    vtkIdType n;
    Edges edges;

    set_points(grid, cloud);
    surface->SetInputData(grid);
    triangles->SetInputConnection(surface->GetOutputPort());
    double ms = median_ms(n_rounds, [&] {
        blank_missing(grid, cloud);
        if (limited)
            blank_long(grid, cloud);
        grid->Modified();
        triangles->Update();
    });
    if (rss)
        *rss = peak_rss_mb();
    vtkCellArray *cells = triangles->GetOutput()->GetPolys();
    for (cells->InitTraversal(); cells->GetNextCell(n, id);)
        if (n == 3)
            edges.add_triangle(static_cast<uint32_t>(id[0]), static_cast<uint32_t>(id[1]),
                               static_cast<uint32_t>(id[2]));
    print_way(name, ms, edges);
}

int main(int argc, char **argv)
{
    int n_rounds = argc > 2 ? std::atoi(argv[2]) : 3;
    Cloud cloud;
    long rss = 0;

    if (argc < 2 || n_rounds < 1) {
        std::fprintf(stderr, "usage: vtk_grid SCAN.pcd [ROUNDS]\n");
        return 2;
    }
    if (pcl::io::loadPCDFile(argv[1], cloud) < 0 || !cloud.isOrganized()) {
        std::fprintf(stderr, "vtk_grid: %s: expected an organized point cloud\n", argv[1]);
        return 1;
    }
    measure<vtkStructuredGridGeometryFilter>("grid", cloud, n_rounds, false, &rss);
    measure<vtkGeometryFilter>("grid_limited", cloud, n_rounds, true, nullptr);
    std::printf("peak_rss_mb %ld\n", rss);
    return 0;
}
