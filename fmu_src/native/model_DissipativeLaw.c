/* The drive speed law of eq. (9), as printed and in tracking form. Follows models/laws.py, which explains it. */
#include <math.h>

#include "ds_memoryless.h"

enum { FORM_PRINTED = 1, FORM_TRACKING = 2 };

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    (void)value;
    (void)journal;
    return DS_OK;
}

static double printed(const double value[], double divisor)
{
    const double bit_speed = value[DS_bit_speed];
    const double speed_ref = value[DS_bit_speed_ref];
    const double ratio = value[DS_c_b] / value[DS_c_a];
    const double rest = 1.0 - value[DS_c_1];
    double omega = value[DS_c_1] * value[DS_top_speed];
    omega = omega + 2.0 * sqrt(ratio * rest) * bit_speed;
    omega = omega + 2.0 * sqrt(value[DS_c_2] * rest) * speed_ref;
    omega = omega - value[DS_c_2] * (speed_ref * speed_ref) / divisor;
    return omega - 2.0 * sqrt(value[DS_c_2] * ratio) * bit_speed * speed_ref / divisor;
}

static double tracking(const double value[])
{
    const double speed_ref = value[DS_bit_speed_ref];
    const double ratio = value[DS_c_b] / value[DS_c_a];
    const double rest = 1.0 - value[DS_c_1];
    double omega = speed_ref + value[DS_bit_torque_ref] / value[DS_c_a];
    omega = omega + value[DS_c_1] * (value[DS_top_speed] - speed_ref);
    return omega + 2.0 * sqrt(ratio * rest) * (value[DS_bit_speed] - speed_ref);
}

static void answer(double value[])
{
    const double limit = value[DS_Omega_max];
    const double top_speed = value[DS_top_speed];
    int guarded = 0;
    double omega;
    if ((int)value[DS_form] == FORM_PRINTED) {
        guarded = fabs(top_speed) < value[DS_top_speed_min];
        omega = printed(value, guarded ? copysign(value[DS_top_speed_min], top_speed) : top_speed);
    } else {
        omega = tracking(value);
    }
    value[DS_guard_active] = guarded;
    value[DS_limit_active] = omega > limit || omega < -limit;
    value[DS_Omega] = omega > limit ? limit : omega < -limit ? -limit : omega;
}

static void tell_changes(const double before[], const double value[], double time, ds_journal *journal)
{
    if (value[DS_guard_active] != before[DS_guard_active]) {
        journal->event(journal->owner, time, value[DS_guard_active] != 0.0
                                                 ? "the divisor of Omega is held at top_speed_min"
                                                 : "the divisor of Omega is the top speed again");
    }
    if (value[DS_limit_active] != before[DS_limit_active]) {
        journal->event(journal->owner, time,
                       value[DS_limit_active] != 0.0 ? "Omega is held at its limit" : "Omega is off its limit again");
    }
}
