#include "ds_quartic.h"

#include <math.h>

#define HALVINGS 200 /* more than it takes to come from [0, 1] to neighbouring numbers anywhere but at 0 */

double ds_quartic_product_integral(ds_quartic a, ds_quartic b, double x)
{
    const double s0 = a.c0 * b.c0;
    const double s1 = a.c0 * b.c1 + a.c1 * b.c0;
    const double s2 = a.c0 * b.c2 + a.c1 * b.c1 + a.c2 * b.c0;
    const double s3 = a.c0 * b.c3 + a.c1 * b.c2 + a.c2 * b.c1 + a.c3 * b.c0;
    const double s4 = a.c0 * b.c4 + a.c1 * b.c3 + a.c2 * b.c2 + a.c3 * b.c1 + a.c4 * b.c0;
    const double s5 = a.c1 * b.c4 + a.c2 * b.c3 + a.c3 * b.c2 + a.c4 * b.c1;
    const double s6 = a.c2 * b.c4 + a.c3 * b.c3 + a.c4 * b.c2;
    const double s7 = a.c3 * b.c4 + a.c4 * b.c3;
    const double s8 = a.c4 * b.c4;
    const double tail = 0.2 * s4 + x * (DS_SIXTH * s5 + x * (DS_SEVENTH * s6 + x * (0.125 * s7 + x * (DS_NINTH * s8))));
    return x * (s0 + x * (0.5 * s1 + x * (DS_THIRD * s2 + x * (0.25 * s3 + x * tail))));
}

double ds_quartic_square_integral(ds_quartic c)
{
    double even = c.c0 * c.c0 + DS_THIRD * (c.c1 * c.c1 + 2.0 * (c.c0 * c.c2)) +
                  0.2 * (c.c2 * c.c2 + 2.0 * (c.c0 * c.c4 + c.c1 * c.c3));
    even = even + DS_SEVENTH * (c.c3 * c.c3 + 2.0 * (c.c2 * c.c4)) + DS_NINTH * (c.c4 * c.c4);
    const double odd =
        c.c0 * c.c1 + 0.5 * (c.c0 * c.c3 + c.c1 * c.c2) + DS_THIRD * (c.c1 * c.c4 + c.c2 * c.c3) + 0.25 * (c.c3 * c.c4);
    return even + odd;
}

static double slope(ds_quartic c, double x)
{
    return c.c1 + x * (2.0 * c.c2 + x * (3.0 * c.c3 + x * (4.0 * c.c4)));
}

/* the places where the second derivative is zero, ascending; DS_NONE for each that does not lie in (0, 1) */
static void inflections(ds_quartic c, double place[2])
{
    const double q = 9.0 * (c.c3 * c.c3) - 24.0 * (c.c4 * c.c2);
    place[0] = DS_NONE;
    place[1] = DS_NONE;
    if (q <= 0.0) {
        return;
    }
    const double root = sqrt(q);
    const double t = c.c3 >= 0.0 ? -(3.0 * c.c3 + root) : root - 3.0 * c.c3;
    double x0 = c.c4 == 0.0 ? DS_NONE : t / (12.0 * c.c4);
    double x1 = 2.0 * c.c2 / t;
    if (!(0.0 < x0 && x0 < 1.0)) {
        x0 = DS_NONE;
    }
    if (!(0.0 < x1 && x1 < 1.0)) {
        x1 = DS_NONE;
    }
    place[0] = x0 <= x1 ? x0 : x1;
    place[1] = x0 <= x1 ? x1 : x0;
}

/* shrink [left, right], between which the slope changes its sign once, to neighbouring numbers */
static double turn(ds_quartic c, double left, double right, double sign)
{
    for (int i = 0; i < HALVINGS; ++i) {
        const double middle = 0.5 * (left + right);
        if (middle <= left || middle >= right) {
            break;
        }
        if (sign * slope(c, middle) > 0.0) {
            left = middle;
        } else {
            right = middle;
        }
    }
    return right;
}

/* the places where the slope changes its sign, ascending; DS_NONE for each that is missing in (0, 1) */
static void stationary_points(ds_quartic c, double found[3])
{
    const double b1 = c.c1 + 2.0 * DS_THIRD * c.c2;
    const double b2 = c.c1 + 4.0 * DS_THIRD * c.c2 + c.c3;
    const double end = slope(c, 1.0);
    found[0] = DS_NONE;
    found[1] = DS_NONE;
    found[2] = DS_NONE;
    if ((c.c1 >= 0.0 && b1 >= 0.0 && b2 >= 0.0 && end >= 0.0) ||
        (c.c1 <= 0.0 && b1 <= 0.0 && b2 <= 0.0 && end <= 0.0)) {
        return; /* the control polygon of the slope, and with it the slope, keeps its sign */
    }
    int count = 0;
    double sign = c.c1 > 0.0 ? 1.0 : -1.0;
    double left = 0.0;
    double place[3];
    inflections(c, place);
    place[2] = 1.0;
    for (int i = 0; i < 3; ++i) {
        if (place[i] <= 1.0) {
            if (sign * slope(c, place[i]) < 0.0) {
                found[count] = turn(c, left, place[i], sign);
                count += 1;
                sign = -sign;
            }
            left = place[i];
        }
    }
}

void ds_quartic_extremes(ds_quartic c, double x0, double x1, double *least, double *greatest)
{
    const double left = ds_quartic_value(c, x0);
    const double right = ds_quartic_value(c, x1);
    double place[3];
    *least = left <= right ? left : right;
    *greatest = left <= right ? right : left;
    stationary_points(c, place);
    for (int i = 0; i < 3; ++i) {
        if (x0 < place[i] && place[i] < x1) {
            const double y = ds_quartic_value(c, place[i]);
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
static double rise(ds_quartic c, double left, double right)
{
    for (int i = 0; i < HALVINGS; ++i) {
        const double middle = 0.5 * (left + right);
        if (middle <= left || middle >= right) {
            break;
        }
        if (ds_quartic_value(c, middle) > 0.0) {
            right = middle;
        } else {
            left = middle;
        }
    }
    return right;
}

double ds_quartic_first_positive(ds_quartic c)
{
    if (c.c0 > 0.0) {
        return 0.0;
    }
    const double b1 = c.c0 + 0.25 * c.c1;
    const double b2 = c.c0 + 0.5 * c.c1 + DS_SIXTH * c.c2;
    const double b3 = c.c0 + 0.75 * c.c1 + 0.5 * c.c2 + 0.25 * c.c3;
    if (b1 <= 0.0 && b2 <= 0.0 && b3 <= 0.0 && ds_quartic_end(c) <= 0.0) {
        return DS_NONE; /* the control polygon, and with it the quartic, is nowhere positive */
    }
    double place[4];
    double left = 0.0;
    stationary_points(c, place);
    place[3] = 1.0;
    for (int i = 0; i < 4; ++i) {
        if (place[i] <= 1.0) {
            if (ds_quartic_value(c, place[i]) > 0.0) {
                return rise(c, left, place[i]);
            }
            left = place[i];
        }
    }
    return DS_NONE;
}

/* the least-squares cubic on [0, 1] of a function that is c on [s, s + w] and 0 elsewhere */
static ds_quartic projection(ds_quartic c, double s, double w)
{
    const double n0 = c.c0 + 0.5 * c.c1 + DS_THIRD * c.c2 + 0.25 * c.c3 + 0.2 * c.c4;
    const double n1 = 0.5 * c.c0 + DS_THIRD * c.c1 + 0.25 * c.c2 + 0.2 * c.c3 + DS_SIXTH * c.c4;
    const double n2 = DS_THIRD * c.c0 + 0.25 * c.c1 + 0.2 * c.c2 + DS_SIXTH * c.c3 + DS_SEVENTH * c.c4;
    const double n3 = 0.25 * c.c0 + 0.2 * c.c1 + DS_SIXTH * c.c2 + DS_SEVENTH * c.c3 + 0.125 * c.c4;
    const double s2 = s * s;
    const double m0 = w * n0;
    const double m1 = w * (s * n0 + w * n1);
    const double m2 = w * (s2 * n0 + w * (2.0 * s * n1 + w * n2));
    const double m3 = w * (s2 * s * n0 + w * (3.0 * s2 * n1 + w * (3.0 * s * n2 + w * n3)));
    const ds_quartic r = {
        16.0 * m0 - 120.0 * m1 + 240.0 * m2 - 140.0 * m3,
        -120.0 * m0 + 1200.0 * m1 - 2700.0 * m2 + 1680.0 * m3,
        240.0 * m0 - 2700.0 * m1 + 6480.0 * m2 - 4200.0 * m3,
        -140.0 * m0 + 1680.0 * m1 - 4200.0 * m2 + 2800.0 * m3,
        0.0,
    };
    return r;
}

ds_quartic ds_quartic_merge(ds_quartic a, ds_quartic b, double u, double limit, double *difference)
{
    ds_quartic base;
    ds_quartic rest;
    double start;
    double width;
    const double jump = fabs(b.c0 - ds_quartic_end(a));
    if (jump > limit) {
        *difference = jump;
        return a;
    }
    if (u >= 0.5) {
        base = ds_quartic_restrict(a, 0.0, 1.0 / u);
        start = u;
        width = 1.0 - u;
        rest = ds_quartic_subtract(b, ds_quartic_restrict(base, u, 1.0));
    } else {
        base = ds_quartic_restrict(b, -u / (1.0 - u), 1.0);
        start = 0.0;
        width = u;
        rest = ds_quartic_subtract(a, ds_quartic_restrict(base, 0.0, u));
    }
    *difference = jump + 0.2 * fabs(rest.c1) + 0.1 * (fabs(rest.c2) + fabs(rest.c3) + fabs(rest.c4));
    if (*difference > limit) {
        return base;
    }
    return ds_quartic_add(base, projection(rest, start, width));
}
