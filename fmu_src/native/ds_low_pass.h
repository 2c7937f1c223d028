/* The filter of first order, exactly for an input on a straight line. Follows models/numerics/low_pass.py. */
#ifndef DS_LOW_PASS_H
#define DS_LOW_PASS_H

#include "ds_exp.h"

/* what is left after `elapsed` seconds of what dies away with a time constant; 0 dies at once */
static inline double ds_fading(double elapsed, double time_constant)
{
    return time_constant > 0.0 ? ds_exp(-elapsed / time_constant) : 0.0;
}

/* output of x' = (input - x) / time_constant after `elapsed` seconds, the input beginning at value and going along slope */
static inline double ds_low_pass(double before, double value, double slope, double elapsed, double time_constant)
{
    const double lag = slope * time_constant;
    return (value + slope * elapsed - lag) + (before - (value - lag)) * ds_fading(elapsed, time_constant);
}

#endif
