/* The drive speed law of eq. (9), as printed and in tracking form. Follows models/controllers/laws.py, which explains it. */
#include <math.h>

#include "ds_limit.h"
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

static int is_guarded(const double value[])
{
    return (int)value[DS_form] == FORM_PRINTED && fabs(value[DS_top_speed]) < value[DS_top_speed_min];
}

static double divisor_of(const double value[])
{
    return is_guarded(value) ? copysign(value[DS_top_speed_min], value[DS_top_speed]) : value[DS_top_speed];
}

static double unlimited(const double value[])
{
    return (int)value[DS_form] == FORM_PRINTED ? printed(value, divisor_of(value)) : tracking(value);
}

static void answer(double value[])
{
    const double limit = value[DS_Omega_max];
    const double omega = unlimited(value);
    value[DS_guard_active] = is_guarded(value);
    value[DS_limit_active] = omega > limit || omega < -limit;
    value[DS_Omega] = ds_limited(omega, -limit, limit);
}

/* how much sqrt(a b) changes with a and b; infinitely where it begins at 0 */
static double root_change(double a, double a_change, double b, double b_change)
{
    const double change = a_change * b + a * b_change;
    if (change == 0.0) {
        return 0.0;
    }
    return a * b > 0.0 ? change / (2.0 * sqrt(a * b)) : copysign(HUGE_VAL, change);
}

static double divisor_change(const double value[], const double seed[])
{
    const double sign = copysign(1.0, value[DS_top_speed]);
    const double margin = fabs(value[DS_top_speed]) - value[DS_top_speed_min];
    const double away = sign * seed[DS_top_speed];
    if (margin == 0.0) {
        return sign * fmax(away, seed[DS_top_speed_min]);
    }
    return sign * (margin > 0.0 ? away : seed[DS_top_speed_min]);
}

static double ratio_change(const double value[], const double seed[])
{
    return (seed[DS_c_b] - value[DS_c_b] / value[DS_c_a] * seed[DS_c_a]) / value[DS_c_a];
}

/* of 2 sqrt(k/g (1 - c_1)) times a speed, the last term of both forms but for their references */
static double bit_term_change(const double value[], const double seed[], double speed, double speed_change)
{
    const double ratio = value[DS_c_b] / value[DS_c_a];
    const double rest = 1.0 - value[DS_c_1];
    const double root = root_change(ratio, ratio_change(value, seed), rest, -seed[DS_c_1]);
    return 2.0 * (root * speed + sqrt(ratio * rest) * speed_change);
}

static double printed_change(const double value[], const double seed[])
{
    const double speed = value[DS_bit_speed];
    const double ref = value[DS_bit_speed_ref];
    const double ref_change = seed[DS_bit_speed_ref];
    const double c_2 = value[DS_c_2];
    const double ratio = value[DS_c_b] / value[DS_c_a];
    const double rest = 1.0 - value[DS_c_1];
    const double divisor = divisor_of(value);
    const double free_root = root_change(c_2, seed[DS_c_2], rest, -seed[DS_c_1]);
    const double bit_root = root_change(c_2, seed[DS_c_2], ratio, ratio_change(value, seed));
    const double dividend = (c_2 * ref + 2.0 * sqrt(c_2 * ratio) * speed) * ref;
    double dividend_change = (seed[DS_c_2] * ref + 2.0 * c_2 * ref_change) * ref + 2.0 * bit_root * speed * ref;
    dividend_change += 2.0 * sqrt(c_2 * ratio) * (seed[DS_bit_speed] * ref + speed * ref_change);
    double change = seed[DS_c_1] * value[DS_top_speed] + value[DS_c_1] * seed[DS_top_speed];
    change += bit_term_change(value, seed, speed, seed[DS_bit_speed]);
    change += 2.0 * (free_root * ref + sqrt(c_2 * rest) * ref_change);
    return change - (dividend_change - dividend / divisor * divisor_change(value, seed)) / divisor;
}

static double tracking_change(const double value[], const double seed[])
{
    const double ref = value[DS_bit_speed_ref];
    const double ref_change = seed[DS_bit_speed_ref];
    const double slip = value[DS_bit_torque_ref] / value[DS_c_a];
    double change = ref_change + (seed[DS_bit_torque_ref] - slip * seed[DS_c_a]) / value[DS_c_a];
    change += seed[DS_c_1] * (value[DS_top_speed] - ref) + value[DS_c_1] * (seed[DS_top_speed] - ref_change);
    return change + bit_term_change(value, seed, value[DS_bit_speed] - ref, seed[DS_bit_speed] - ref_change);
}

static void differentiate(const double value[], const double seed[], double change[])
{
    const double limit = value[DS_Omega_max];
    const double limit_change = seed[DS_Omega_max];
    const double omega = unlimited(value);
    const double free = (int)value[DS_form] == FORM_PRINTED ? printed_change(value, seed) : tracking_change(value, seed);
    change[DS_Omega] = ds_limited_change(omega, free, -limit, -limit_change, limit, limit_change);
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
