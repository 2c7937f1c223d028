/* An exponential made of + - * only: the same bits on every platform. Follows models/numerics/exponential.py. */
#ifndef DS_EXP_H
#define DS_EXP_H

#include <stdint.h>
#include <string.h>

/* e^x to less than one unit in the last place; 0 below -708, that of 709 above it */
static inline double ds_exp(double x)
{
    if (x < -708.0) {
        return 0.0;
    }
    if (x > 709.0) {
        x = 709.0;
    }
    const int k = (int)(x * 1.4426950408889634 + 1024.5) - 1024;
    const double high = x - k * 0.6931471803691238;
    const double low = k * 1.9082149292705877e-10;
    const double r = high - low;
    const double s = r * r;
    const double q = s * s;
    const double p01 = 0.5 + r * 0.16666666666666666;
    const double p23 = 0.041666666666666664 + r * 0.008333333333333333;
    const double p45 = 0.001388888888888889 + r * 0.0001984126984126984;
    const double p67 = 2.48015873015873e-05 + r * 2.7557319223985893e-06;
    const double p89 = 2.755731922398589e-07 + r * 2.505210838544172e-08;
    const double pab = 2.08767569878681e-09 + r * 1.6059043836821613e-10;
    const double p = (p01 + s * p23) + q * ((p45 + s * p67) + q * (p89 + s * pab));
    const uint64_t bits = (uint64_t)(k + 1023) << 52;
    double scale;
    memcpy(&scale, &bits, sizeof scale);
    return (1.0 + (high + (s * p - low))) * scale;
}

#endif
