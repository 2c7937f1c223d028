/* Noise that is the same on every platform. Follows models/numerics/noise.py. */
#ifndef DS_NOISE_H
#define DS_NOISE_H

#include <stdint.h>

/* a number between 0 and 1; the state is a whole number from 1 to 2147483646 and goes on to the next */
static inline double ds_uniform(double *state)
{
    const int64_t following = (int64_t)*state * 48271 % 2147483647;
    *state = (double)following;
    return (double)following / 2147483647.0;
}

/* a number of mean 0 and deviation 1, between -6 and 6 */
static inline double ds_normal(double *state)
{
    double total = -6.0;
    for (int i = 0; i < 12; ++i) {
        total = total + ds_uniform(state);
    }
    return total;
}

#endif
