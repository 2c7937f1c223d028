/* Sine and cosine made of + - * only: the same bits on every platform. Follows models/numerics/trigonometry.py. */
#ifndef DS_TRIGONOMETRY_H
#define DS_TRIGONOMETRY_H

typedef struct {
    double sine;
    double cosine;
} ds_sine_cosine;

/* of an angle between -1e5 and 1e5 [rad] */
static inline ds_sine_cosine ds_sine_and_cosine(double angle)
{
    const int quarters = (int)(angle * 0.6366197723675814 + 65536.5) - 65536;
    const double x = (angle - quarters * 1.5707963267341256) - quarters * 6.077100506506192e-11;
    const double s = x * x;
    double sine = 2.8114572543455206e-15;
    sine = sine * s - 7.647163731819816e-13;
    sine = sine * s + 1.6059043836821613e-10;
    sine = sine * s - 2.505210838544172e-08;
    sine = sine * s + 2.7557319223985893e-06;
    sine = sine * s - 0.0001984126984126984;
    sine = sine * s + 0.008333333333333333;
    sine = sine * s - 0.16666666666666666;
    sine = x + x * (sine * s);
    double cosine = 4.779477332387385e-14;
    cosine = cosine * s - 1.1470745597729725e-11;
    cosine = cosine * s + 2.08767569878681e-09;
    cosine = cosine * s - 2.755731922398589e-07;
    cosine = cosine * s + 2.48015873015873e-05;
    cosine = cosine * s - 0.001388888888888889;
    cosine = cosine * s + 0.041666666666666664;
    cosine = cosine * s - 0.5;
    cosine = 1.0 + cosine * s;
    const ds_sine_cosine turned[4] = {{sine, cosine}, {cosine, -sine}, {-sine, -cosine}, {-cosine, sine}};
    return turned[(quarters + 65536) % 4];
}

#endif
