/* Quartic polynomials on the unit interval, the form every wave and every speed is kept in.
 * Follows models/numerics/quartic.py. */
#ifndef DS_QUARTIC_H
#define DS_QUARTIC_H

#include "ds_linkage.h"

#define DS_THIRD 0.3333333333333333
#define DS_SIXTH 0.16666666666666666
#define DS_SEVENTH 0.14285714285714285
#define DS_NINTH 0.1111111111111111
#define DS_NONE 2.0 /* what a search in [0, 1] returns when there is nothing to find */

typedef struct {
    double c0, c1, c2, c3, c4; /* of c0 + c1 x + ... + c4 x^4, x from 0 at the begin of a piece to 1 at its end */
} ds_quartic;

static inline double ds_quartic_value(ds_quartic c, double x)
{
    return c.c0 + x * (c.c1 + x * (c.c2 + x * (c.c3 + x * c.c4)));
}

/* value at 1 */
static inline double ds_quartic_end(ds_quartic c)
{
    return c.c0 + c.c1 + c.c2 + c.c3 + c.c4;
}

/* integral from 0 to x */
static inline double ds_quartic_integral(ds_quartic c, double x)
{
    return x * (c.c0 + x * (0.5 * c.c1 + x * (DS_THIRD * c.c2 + x * (0.25 * c.c3 + x * (0.2 * c.c4)))));
}

/* the quartic whose [0, 1] is [x0, x1] of the given one; outside [0, 1] this extends it */
static inline ds_quartic ds_quartic_restrict(ds_quartic c, double x0, double x1)
{
    if (x0 == 0.0 && x1 == 1.0) {
        return c;
    }
    const double w = x1 - x0;
    const double w2 = w * w;
    const double d1 = c.c1 + x0 * (2.0 * c.c2 + x0 * (3.0 * c.c3 + x0 * (4.0 * c.c4)));
    const double d2 = c.c2 + x0 * (3.0 * c.c3 + x0 * (6.0 * c.c4));
    const double d3 = c.c3 + x0 * (4.0 * c.c4);
    const ds_quartic r = {ds_quartic_value(c, x0), w * d1, w2 * d2, w2 * w * d3, w2 * w2 * c.c4};
    return r;
}

static inline ds_quartic ds_quartic_add(ds_quartic a, ds_quartic b)
{
    const ds_quartic r = {a.c0 + b.c0, a.c1 + b.c1, a.c2 + b.c2, a.c3 + b.c3, a.c4 + b.c4};
    return r;
}

static inline ds_quartic ds_quartic_subtract(ds_quartic a, ds_quartic b)
{
    const ds_quartic r = {a.c0 - b.c0, a.c1 - b.c1, a.c2 - b.c2, a.c3 - b.c3, a.c4 - b.c4};
    return r;
}

/* integral of a b from 0 to x, exact but for rounding */
DS_SHARED double ds_quartic_product_integral(ds_quartic a, ds_quartic b, double x);

/* integral of the square from 0 to 1, exact but for rounding */
DS_SHARED double ds_quartic_square_integral(ds_quartic c);

/* least and greatest value on [x0, x1] */
DS_SHARED void ds_quartic_extremes(ds_quartic c, double x0, double x1, double *least, double *greatest);

/* first x in [0, 1] from which the quartic is positive, DS_NONE if there is none */
DS_SHARED double ds_quartic_first_positive(ds_quartic c);

/* the quartic on [0, 1] with the first four moments of a on [0, u] and b on [u, 1]; *difference: how much they differ.
 * Where it exceeds the limit the quartic is not worked out */
DS_SHARED ds_quartic ds_quartic_merge(ds_quartic a, ds_quartic b, double u, double limit, double *difference);

/* the least-squares cubic on [0, 1]: the quartic less its share of the fourth Legendre polynomial */
static inline ds_quartic ds_quartic_flatten(ds_quartic c)
{
    const ds_quartic r = {
        c.c0 - 0.014285714285714285 * c.c4,
        c.c1 + 0.2857142857142857 * c.c4,
        c.c2 - 1.2857142857142858 * c.c4,
        c.c3 + 2.0 * c.c4,
        0.0,
    };
    return r;
}

#endif
