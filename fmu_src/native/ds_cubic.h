/* Cubic polynomials on the unit interval, the form every wave and every speed is kept in. Follows models/cubic.py. */
#ifndef DS_CUBIC_H
#define DS_CUBIC_H

#define DS_THIRD 0.3333333333333333
#define DS_NONE 2.0 /* what a search in [0, 1] returns when there is nothing to find */

typedef struct {
    double c0, c1, c2, c3; /* of c0 + c1 x + c2 x^2 + c3 x^3, x from 0 at the begin of a piece to 1 at its end */
} ds_cubic;

static inline double ds_cubic_value(ds_cubic c, double x)
{
    return c.c0 + x * (c.c1 + x * (c.c2 + x * c.c3));
}

/* integral from 0 to x */
static inline double ds_cubic_integral(ds_cubic c, double x)
{
    return x * (c.c0 + x * (0.5 * c.c1 + x * (DS_THIRD * c.c2 + x * (0.25 * c.c3))));
}

/* the cubic whose [0, 1] is [x0, x1] of the given one; outside [0, 1] this extends it */
static inline ds_cubic ds_cubic_restrict(ds_cubic c, double x0, double x1)
{
    if (x0 == 0.0 && x1 == 1.0) {
        return c;
    }
    const double w = x1 - x0;
    const double w2 = w * w;
    const double d1 = c.c1 + x0 * (2.0 * c.c2 + x0 * (3.0 * c.c3));
    const double d2 = c.c2 + x0 * (3.0 * c.c3);
    const ds_cubic r = {ds_cubic_value(c, x0), w * d1, w2 * d2, w2 * w * c.c3};
    return r;
}

static inline ds_cubic ds_cubic_add(ds_cubic a, ds_cubic b)
{
    const ds_cubic r = {a.c0 + b.c0, a.c1 + b.c1, a.c2 + b.c2, a.c3 + b.c3};
    return r;
}

static inline ds_cubic ds_cubic_subtract(ds_cubic a, ds_cubic b)
{
    const ds_cubic r = {a.c0 - b.c0, a.c1 - b.c1, a.c2 - b.c2, a.c3 - b.c3};
    return r;
}

/* the cubic with values v0, v1 and slopes m0, m1 (per unit of x) at 0 and 1 */
static inline ds_cubic ds_cubic_hermite(double v0, double v1, double m0, double m1)
{
    const double rise = v1 - v0;
    const ds_cubic r = {v0, m0, 3.0 * rise - 2.0 * m0 - m1, m0 + m1 - 2.0 * rise};
    return r;
}

/* integral of a b from 0 to x, exact but for rounding */
double ds_cubic_product_integral(ds_cubic a, ds_cubic b, double x);

/* least and greatest value on [x0, x1] */
void ds_cubic_extremes(ds_cubic c, double x0, double x1, double *least, double *greatest);

/* first x in [0, 1] from which the cubic is positive, DS_NONE if there is none */
double ds_cubic_first_positive(ds_cubic c);

/* the cubic on [0, 1] with the first four moments of a on [0, u] and b on [u, 1]; *difference: how much a and b differ */
ds_cubic ds_cubic_merge(ds_cubic a, ds_cubic b, double u, double *difference);

#endif
