/* Impedance and stick-slip frequency of the string that the parameters G, J, I, L and I_B describe. Follows TopOfString of
 * models/controllers/virtual_drive.py. */
#ifndef DS_STICK_SLIP_H
#define DS_STICK_SLIP_H

#include <math.h>

#include "ds_table.h"
#include "ds_trigonometry.h"

static inline double ds_impedance(const double value[])
{
    return sqrt(value[DS_I] * value[DS_G] * value[DS_J]);
}

/* lowest frequency of the string with its top held, tan(omega Gamma) = Z / (omega I_B), rad/s */
static inline double ds_stick_slip_frequency(const double value[])
{
    const double away = value[DS_L] * sqrt(value[DS_I] / (value[DS_G] * value[DS_J]));
    const double k = ds_impedance(value) * away / value[DS_I_B];
    double x = sqrt(k / (1.0 + 0.4052847345693511 * k));
    for (int i = 0; i < 8; ++i) {
        const ds_sine_cosine of = ds_sine_and_cosine(x);
        x = x - (x * of.sine - k * of.cosine) / (of.sine + x * of.cosine + k * of.sine);
    }
    return x / away;
}

#endif
