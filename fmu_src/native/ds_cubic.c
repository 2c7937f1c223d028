#include "ds_cubic.h"

#include <math.h>

double ds_cubic_product_integral(ds_cubic a, ds_cubic b, double x)
{
    const double s0 = a.c0 * b.c0;
    const double s1 = a.c0 * b.c1 + a.c1 * b.c0;
    const double s2 = a.c0 * b.c2 + a.c1 * b.c1 + a.c2 * b.c0;
    const double s3 = a.c0 * b.c3 + a.c1 * b.c2 + a.c2 * b.c1 + a.c3 * b.c0;
    const double s4 = a.c1 * b.c3 + a.c2 * b.c2 + a.c3 * b.c1;
    const double s5 = a.c2 * b.c3 + a.c3 * b.c2;
    const double s6 = a.c3 * b.c3;
    const double tail = 0.25 * s3 + x * (0.2 * s4 + x * (0.16666666666666666 * s5 + x * (0.14285714285714285 * s6)));
    return x * (s0 + x * (0.5 * s1 + x * (DS_THIRD * s2 + x * tail)));
}

/* the two places where the slope is zero, ascending; DS_NONE for each that does not lie in (0, 1) */
static void stationary_points(ds_cubic c, double place[2])
{
    const double q = c.c2 * c.c2 - 3.0 * c.c3 * c.c1;
    place[0] = DS_NONE;
    place[1] = DS_NONE;
    if (q <= 0.0) {
        return;
    }
    const double t = c.c2 >= 0.0 ? -(c.c2 + sqrt(q)) : sqrt(q) - c.c2;
    double x0 = c.c3 == 0.0 ? DS_NONE : t / (3.0 * c.c3);
    double x1 = c.c1 / t;
    if (!(0.0 < x0 && x0 < 1.0)) {
        x0 = DS_NONE;
    }
    if (!(0.0 < x1 && x1 < 1.0)) {
        x1 = DS_NONE;
    }
    place[0] = x0 <= x1 ? x0 : x1;
    place[1] = x0 <= x1 ? x1 : x0;
}

void ds_cubic_extremes(ds_cubic c, double x0, double x1, double *least, double *greatest)
{
    const double left = ds_cubic_value(c, x0);
    const double right = ds_cubic_value(c, x1);
    double place[2];
    *least = left <= right ? left : right;
    *greatest = left <= right ? right : left;
    stationary_points(c, place);
    for (int i = 0; i < 2; ++i) {
        if (x0 < place[i] && place[i] < x1) {
            const double y = ds_cubic_value(c, place[i]);
            if (y < *least) {
                *least = y;
            }
            if (y > *greatest) {
                *greatest = y;
            }
        }
    }
}

/* shrink [left, right], not positive at left and positive at right, to neighbouring numbers; return the right one */
static double bisect(ds_cubic c, double left, double right)
{
    for (int i = 0; i < 200; ++i) {
        const double middle = 0.5 * (left + right);
        if (middle <= left || middle >= right) {
            break;
        }
        if (ds_cubic_value(c, middle) > 0.0) {
            right = middle;
        } else {
            left = middle;
        }
    }
    return right;
}

double ds_cubic_first_positive(ds_cubic c)
{
    if (c.c0 > 0.0) {
        return 0.0;
    }
    const double b1 = c.c0 + DS_THIRD * c.c1;
    const double b2 = b1 + DS_THIRD * (c.c1 + c.c2);
    const double end = c.c0 + c.c1 + c.c2 + c.c3;
    if (b1 <= 0.0 && b2 <= 0.0 && end <= 0.0) {
        return DS_NONE; /* the control polygon, and with it the cubic, is nowhere positive */
    }
    double place[3];
    double left = 0.0;
    stationary_points(c, place);
    place[2] = 1.0;
    for (int i = 0; i < 3; ++i) {
        if (place[i] <= 1.0) {
            if (ds_cubic_value(c, place[i]) > 0.0) {
                return bisect(c, left, place[i]);
            }
            left = place[i];
        }
    }
    return DS_NONE;
}

/* the least-squares cubic on [0, 1] of a function that is c on [start, start + width] and 0 elsewhere */
static ds_cubic projection(ds_cubic c, double s, double w)
{
    const double n0 = c.c0 + 0.5 * c.c1 + DS_THIRD * c.c2 + 0.25 * c.c3;
    const double n1 = 0.5 * c.c0 + DS_THIRD * c.c1 + 0.25 * c.c2 + 0.2 * c.c3;
    const double n2 = DS_THIRD * c.c0 + 0.25 * c.c1 + 0.2 * c.c2 + 0.16666666666666666 * c.c3;
    const double n3 = 0.25 * c.c0 + 0.2 * c.c1 + 0.16666666666666666 * c.c2 + 0.14285714285714285 * c.c3;
    const double m0 = w * n0;
    const double m1 = w * (s * n0 + w * n1);
    const double m2 = w * (s * s * n0 + w * (2.0 * s * n1 + w * n2));
    const double m3 = w * (s * s * s * n0 + w * (3.0 * s * s * n1 + w * (3.0 * s * n2 + w * n3)));
    const ds_cubic r = {
        16.0 * m0 - 120.0 * m1 + 240.0 * m2 - 140.0 * m3,
        -120.0 * m0 + 1200.0 * m1 - 2700.0 * m2 + 1680.0 * m3,
        240.0 * m0 - 2700.0 * m1 + 6480.0 * m2 - 4200.0 * m3,
        -140.0 * m0 + 1680.0 * m1 - 4200.0 * m2 + 2800.0 * m3,
    };
    return r;
}

ds_cubic ds_cubic_merge(ds_cubic a, ds_cubic b, double u, double *difference)
{
    ds_cubic base;
    ds_cubic rest;
    double start;
    double width;
    double jump;
    if (u >= 0.5) {
        base = ds_cubic_restrict(a, 0.0, 1.0 / u);
        start = u;
        width = 1.0 - u;
        rest = ds_cubic_subtract(b, ds_cubic_restrict(base, u, 1.0));
        jump = rest.c0;
    } else {
        base = ds_cubic_restrict(b, -u / (1.0 - u), 1.0);
        start = 0.0;
        width = u;
        rest = ds_cubic_subtract(a, ds_cubic_restrict(base, 0.0, u));
        jump = ds_cubic_value(rest, 1.0);
    }
    *difference = fabs(jump) + 0.2 * fabs(rest.c1) + 0.1 * (fabs(rest.c2) + fabs(rest.c3));
    return ds_cubic_add(base, projection(rest, start, width));
}
