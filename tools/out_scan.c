/* PTX and PCD from a plane and its geometry. */
#include "tools/out_frames.h"

#include "core/base/bytes.h"

#include <math.h>
#include <string.h>

#define PCD_POINT_LEN 16 /* x y z intensity, f32 */

/* 0..1; one half where there is no attribute, as PTX writers do. */
static double intensity(const struct dx_plane *plane, size_t k)
{
    if (plane->attr_bytes == 0)
        return 0.5;
    return dx_plane_attr(plane, k) / (plane->attr_bytes == 1 ? 255.0 : 65535.0);
}

/* A return as a point: its own where the plane has them. */
static void point(float p[3], const struct dx_plane *plane, const struct dx_geometry *g,
                  uint32_t row, uint32_t col)
{
    size_t k = (size_t)row * plane->width + col;

    if (plane->xyz)
        memcpy(p, plane->xyz + 3 * k, 3 * sizeof(*p));
    else
        dx_geometry_point(g, row, col, dx_plane_range(plane, k), p);
}

/* Digits after the point that keep a range within a twentieth of its unit. */
static int decimals(const struct dx_geometry *g)
{
    double step = 1e-6;
    int n = 6;

    for (; step > (double)g->unit_m / 20 && n < 9; step /= 10)
        n++;
    return n;
}

/* world = [x y z 1] M: the pose's columns are M's rows. Position and axes say the same again. */
static void ptx_header(FILE *f, const struct dx_geometry *g)
{
    const double *p = g->pose;

    fprintf(f, "%u\n%u\n", g->width, g->height);
    fprintf(f, "%.17g %.17g %.17g\n", p[3], p[7], p[11]);
    for (int k = 0; k < 3; k++)
        fprintf(f, "%.17g %.17g %.17g\n", p[k], p[4 + k], p[8 + k]);
    for (int k = 0; k < 4; k++)
        fprintf(f, "%.17g %.17g %.17g %d\n", p[k], p[4 + k], p[8 + k], k == 3);
}

void dx_out_ptx(FILE *f, const struct dx_plane *plane, const struct dx_geometry *g)
{
    int n = plane->xyz ? 9 : decimals(g); /* nine significant digits tell every f32 */

    ptx_header(f, g);
    for (uint32_t col = 0; col < plane->width; col++)
        for (uint32_t row = 0; row < plane->height; row++) {
            size_t k = (size_t)row * plane->width + col;
            float p[3];

            if (dx_plane_range(plane, k) == 0) {
                fputs("0 0 0 0.5\n", f);
                continue;
            }
            point(p, plane, g, row, col);
            fprintf(f, plane->xyz ? "%.*g %.*g %.*g %.6f\n" : "%.*f %.*f %.*f %.6f\n", n,
                    (double)p[0], n, (double)p[1], n, (double)p[2], intensity(plane, k));
        }
}

/* Quaternion (w, x, y, z) of the pose's rotation, from its largest component on (Shepperd 1978). */
static void quaternion(const double pose[12], double q[4])
{
    double m[3][3], four[4], largest;
    int top = 0;

    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            m[i][j] = pose[4 * i + j];
    four[0] = 1 + m[0][0] + m[1][1] + m[2][2];
    for (int k = 0; k < 3; k++)
        four[1 + k] = 1 + 2 * m[k][k] - m[0][0] - m[1][1] - m[2][2];
    for (int k = 1; k < 4; k++)
        if (four[k] > four[top])
            top = k;
    largest = sqrt(four[top]) / 2;
    for (int k = 0; k < 4; k++) {
        int a = top > 0 ? top - 1 : k - 1; /* axes of the pair (top, k) */
        int b = top > 0 && k > 0 ? k - 1 : a;
        int u = (a + 1) % 3, v = (a + 2) % 3;

        if (k == top)
            q[k] = largest;
        else if (top == 0 || k == 0)
            q[k] = (m[v][u] - m[u][v]) / (4 * largest);
        else
            q[k] = (m[a][b] + m[b][a]) / (4 * largest);
    }
}

static void pcd_header(FILE *f, const struct dx_plane *plane, const struct dx_geometry *g)
{
    double q[4];

    quaternion(g->pose, q);
    fprintf(f,
            "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity\n"
            "SIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH %u\nHEIGHT %u\n",
            plane->width, plane->height);
    fprintf(f, "VIEWPOINT %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", g->pose[3], g->pose[7],
            g->pose[11], q[0], q[1], q[2], q[3]);
    fprintf(f, "POINTS %zu\nDATA binary\n", dx_plane_n_dexels(plane));
}

void dx_out_pcd(FILE *f, const struct dx_plane *plane, const struct dx_geometry *g)
{
    pcd_header(f, plane, g);
    for (uint32_t row = 0; row < plane->height; row++)
        for (uint32_t col = 0; col < plane->width; col++) {
            size_t k = (size_t)row * plane->width + col;
            float p[4] = {NAN, NAN, NAN, 0};
            uint8_t bytes[PCD_POINT_LEN];

            if (dx_plane_range(plane, k)) {
                point(p, plane, g, row, col);
                p[3] = (float)intensity(plane, k);
            }
            for (int m = 0; m < 4; m++)
                dx_put_u32(bytes + 4 * m, dx_f32_bits(p[m]));
            fwrite(bytes, 1, sizeof(bytes), f);
        }
}
