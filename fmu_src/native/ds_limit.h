/* A value held within limits, and how much it changes with what it is made from. */
#ifndef DS_LIMIT_H
#define DS_LIMIT_H

#include <math.h>

static inline double ds_limited(double value, double low, double high)
{
    return value > high ? high : value < low ? low : value;
}

/* derivative of ds_limited; where the value is at a limit, to the side it goes to */
static inline double ds_limited_change(double value, double change, double low, double low_change, double high,
                                       double high_change)
{
    if (value >= high) {
        return value > high ? high_change : fmin(change, high_change);
    }
    if (value <= low) {
        return value < low ? low_change : fmax(change, low_change);
    }
    return change;
}

#endif
