/* Collocation at the four Lobatto points of [0, 1], of order six. Follows models/numerics/collocation.py. */
#ifndef DS_COLLOCATION_H
#define DS_COLLOCATION_H

#include "ds_quartic.h"

static const double ds_nodes[4] = {0.0, 0.276393202250021, 0.7236067977499789, 1.0};
static const double ds_weights[4] = {0.08333333333333333, 0.4166666666666667, 0.4166666666666667, 0.08333333333333333};

/* the quartic with a value at 0 and slopes at the four points */
static inline ds_quartic ds_antiderivative(double start, const double g[4])
{
    const ds_quartic r = {
        start,
        g[0],
        -3.0 * g[0] + 4.045084971874737 * g[1] - 1.545084971874737 * g[2] + 0.5 * g[3],
        3.3333333333333335 * g[0] - 6.4235032770828075 * g[1] + 4.756836610416141 * g[2] - 1.6666666666666667 * g[3],
        -1.25 * g[0] + 2.7950849718747373 * g[1] - 2.7950849718747373 * g[2] + 1.25 * g[3],
    };
    return r;
}

/* the values of the antiderivative at the three points after the first */
static inline void ds_collocation_values(double start, const double g[4], double w[3])
{
    w[0] = start + (0.11030056647916492 * g[0] + 0.1896994335208351 * g[1]) +
           (-0.03390736422914389 * g[2] + 0.010300566479164915 * g[3]);
    w[1] = start + (0.07303276685416842 * g[0] + 0.45057403089581055 * g[1]) +
           (0.2269672331458316 * g[2] - 0.02696723314583158 * g[3]);
    w[2] = start + (0.08333333333333333 * g[0] + 0.4166666666666667 * g[1]) +
           (0.4166666666666667 * g[2] + 0.08333333333333333 * g[3]);
}

/* Newton's correction of the three values: the solution of (1 - A diag(jacobian)) d = residual */
static inline void ds_collocation_correction(const double residual[3], const double jacobian[3], double d[3])
{
    const double p = jacobian[0];
    const double q = jacobian[1];
    const double r = jacobian[2];
    const double a11 = 1.0 - 0.1896994335208351 * p;
    const double a12 = 0.03390736422914389 * q;
    const double a13 = -0.010300566479164915 * r;
    const double a21 = -0.45057403089581055 * p;
    const double a22 = 1.0 - 0.2269672331458316 * q;
    const double a23 = 0.02696723314583158 * r;
    const double a31 = -0.4166666666666667 * p;
    const double a32 = -0.4166666666666667 * q;
    const double a33 = 1.0 - 0.08333333333333333 * r;
    const double f2 = a21 / a11;
    const double f3 = a31 / a11;
    const double b22 = a22 - f2 * a12;
    const double b23 = a23 - f2 * a13;
    const double b32 = a32 - f3 * a12;
    const double b33 = a33 - f3 * a13;
    const double s2 = residual[1] - f2 * residual[0];
    const double s3 = residual[2] - f3 * residual[0];
    const double f = b32 / b22;
    d[2] = (s3 - f * s2) / (b33 - f * b23);
    d[1] = (s2 - b23 * d[2]) / b22;
    d[0] = (residual[0] - a12 * d[1] - a13 * d[2]) / a11;
}

#endif
