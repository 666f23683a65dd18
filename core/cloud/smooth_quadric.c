/* The paraboloid over a fitted plane: it takes away the leading bias of Q, by which a plane shrinks
 * what is curved. */
#include "core/cloud/smooth_fit.h"
#include "core/cloud/smooth_lanes.h"

#include <math.h>

#define N_TERMS   6 /* 1 x y xx xy yy */
#define N_MOMENTS 15
#define MIN_PIVOT 1e-6 /* of Cholesky, over its diagonal: less is not determined */
#define N_ROUNDS  1    /* by its own heights after the plane's */

struct normal_equations {
    double a[N_TERMS][N_TERMS], b[N_TERMS];
};

/* Two vectors that with the normal make a right-handed frame. */
static void set_frame(struct dx_robust_quadric *q, const double n[3])
{
    /* the axis least along the normal, without its part along it */
    const int k = fabs(n[0]) < fabs(n[1]) ? (fabs(n[0]) < fabs(n[2]) ? 0 : 2)
                                          : (fabs(n[1]) < fabs(n[2]) ? 1 : 2);
    const double len = sqrt(1 - n[k] * n[k]);

    for (int i = 0; i < 3; i++)
        q->u[i] = ((i == k) - n[k] * n[i]) / len;
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, l = (i + 2) % 3;

        q->v[i] = n[j] * q->u[l] - n[l] * q->u[j];
    }
}

/* The points in the frame: x, y and height over the place. */
struct turned {
    double x[DX_ROBUST_MAX_POINTS], y[DX_ROBUST_MAX_POINTS], h[DX_ROBUST_MAX_POINTS];
};

static void turn(struct turned *f, const struct dx_robust_points *p,
                 const struct dx_robust_quadric *q, const double n[3])
{
    for (uint32_t i = 0; i < p->n + p->n % 2; i++) {
        f->x[i] = q->u[0] * p->x[i] + q->u[1] * p->y[i] + q->u[2] * p->z[i];
        f->y[i] = q->v[0] * p->x[i] + q->v[1] * p->y[i] + q->v[2] * p->z[i];
        f->h[i] = n[0] * p->x[i] + n[1] * p->y[i] + n[2] * p->z[i];
    }
}

/* Moments of x and y to the fourth order: 1 x y xx xy yy xxx xxy xyy yyy xxxx xxxy xxyy xyyy yyyy;
 * and of the height to the second. */
static void sum_moments(dx_lanes m[N_MOMENTS], dx_lanes b[N_TERMS],
                        const struct dx_robust_points *p, const struct turned *f)
{
    for (uint32_t i = 0; i < p->n; i += 2) {
        const dx_lanes x = dx_lanes_at(f->x, i), y = dx_lanes_at(f->y, i), h = dx_lanes_at(f->h, i);
        const dx_lanes w = dx_lanes_at(p->weight, i), wx = w * x, wy = w * y;
        const dx_lanes term[N_TERMS] = {w, wx, wy, wx * x, wx * y, wy * y};
        const dx_lanes xx = x * x, xy = x * y, yy = y * y;

        for (int k = 0; k < N_TERMS; k++) {
            m[k] += term[k];
            b[k] += term[k] * h;
        }
        m[6] += term[3] * x;
        m[7] += term[3] * y;
        m[8] += term[5] * x;
        m[9] += term[5] * y;
        m[10] += term[3] * xx;
        m[11] += term[3] * xy;
        m[12] += term[3] * yy;
        m[13] += term[5] * xy;
        m[14] += term[5] * yy;
    }
}

static void set_equations(struct normal_equations *e, const struct dx_robust_points *p,
                          const struct turned *f)
{
    static const uint8_t of[N_TERMS][N_TERMS] = {
        {0, 1, 2, 3, 4, 5},    {1, 3, 4, 6, 7, 8},    {2, 4, 5, 7, 8, 9},
        {3, 6, 7, 10, 11, 12}, {4, 7, 8, 11, 12, 13}, {5, 8, 9, 12, 13, 14},
    };
    dx_lanes m[N_MOMENTS] = {{0}}, b[N_TERMS] = {{0}};

    sum_moments(m, b, p, f);
    for (int i = 0; i < N_TERMS; i++) {
        e->b[i] = b[i][0] + b[i][1];
        for (int j = 0; j < N_TERMS; j++)
            e->a[i][j] = m[of[i][j]][0] + m[of[i][j]][1];
    }
}

/* Cholesky; b becomes the solution. */
static bool solve(struct normal_equations *e)
{
    double(*a)[N_TERMS] = e->a, *b = e->b;

    for (int i = 0; i < N_TERMS; i++) {
        const double diagonal = a[i][i];

        for (int j = 0; j <= i; j++) {
            double s = a[i][j];

            for (int k = 0; k < j; k++)
                s -= a[i][k] * a[j][k];
            if (j < i) {
                a[i][j] = s / a[j][j];
                continue;
            }
            if (!(s > MIN_PIVOT * diagonal))
                return false;
            a[i][i] = sqrt(s);
        }
    }
    for (int i = 0; i < N_TERMS; i++) {
        for (int k = 0; k < i; k++)
            b[i] -= a[i][k] * b[k];
        b[i] /= a[i][i];
    }
    for (int i = N_TERMS - 1; i >= 0; i--) {
        for (int k = i + 1; k < N_TERMS; k++)
            b[i] -= a[k][i] * b[k];
        b[i] /= a[i][i];
    }
    return true;
}

/* Weights by the heights over the paraboloid. */
static void weigh(struct dx_robust_points *p, const struct turned *f, const double t[N_TERMS],
                  double sr)
{
    const dx_lanes k = dx_lanes_all(1 / (2 * sr * sr));
    dx_lanes c[N_TERMS];

    for (int i = 0; i < N_TERMS; i++)
        c[i] = dx_lanes_all(t[i]);
    for (uint32_t i = 0; i < p->n; i += 2) {
        const dx_lanes x = dx_lanes_at(f->x, i), y = dx_lanes_at(f->y, i);
        const dx_lanes on = c[0] + c[1] * x + c[2] * y + (c[3] * x + c[4] * y) * x + c[5] * y * y;
        const dx_lanes r = dx_lanes_at(f->h, i) - on;

        dx_lanes_put(p->weight, i, dx_lanes_times_exp_minus(dx_lanes_at(p->w, i), k * r * r));
    }
}

bool dx_robust_quadric(struct dx_robust_quadric *q, struct dx_robust_points *p,
                       const struct dx_robust_plane *plane, double sr)
{
    struct turned f;

    set_frame(q, plane->normal);
    turn(&f, p, q, plane->normal);
    for (int round = 0; round <= N_ROUNDS; round++) {
        struct normal_equations e;

        if (round > 0)
            weigh(p, &f, q->term, sr);
        set_equations(&e, p, &f);
        if (!solve(&e))
            return false;
        for (int k = 0; k < N_TERMS; k++)
            q->term[k] = e.b[k];
    }
    return true;
}
