/* The weight on bit of eq. (22). Follows models/controllers/laws.py. */
#include <math.h>

#include "ds_condition.h"
#include "ds_limit.h"
#include "ds_memoryless.h"

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    return ds_at_least("WOB_max", value[DS_WOB_max], "WOB_0", value[DS_WOB_0], journal);
}

static double unlimited(const double value[])
{
    return value[DS_K_w] * fabs(value[DS_bit_speed]) + value[DS_WOB_0];
}

static void answer(double value[])
{
    value[DS_WOB] = ds_limited(unlimited(value), -HUGE_VAL, value[DS_WOB_max]);
}

static void differentiate(const double value[], const double seed[], double change[])
{
    const double speed = value[DS_bit_speed];
    const double weight = unlimited(value);
    const double limit = value[DS_WOB_max];
    const double faster = speed > 0.0 ? seed[DS_bit_speed] : speed < 0.0 ? -seed[DS_bit_speed] : fabs(seed[DS_bit_speed]);
    const double heavier = seed[DS_K_w] * fabs(speed) + value[DS_K_w] * faster + seed[DS_WOB_0];
    change[DS_WOB] = ds_limited_change(weight, heavier, -HUGE_VAL, 0.0, limit, seed[DS_WOB_max]);
}

static void tell_changes(const double before[], const double value[], double time, ds_journal *journal)
{
    const int limited = unlimited(value) > value[DS_WOB_max];
    if (limited != (unlimited(before) > before[DS_WOB_max])) {
        journal->event(journal->owner, time, limited ? "WOB is held at its limit" : "WOB is off its limit again");
    }
}
