/* The rotation asked for, smoothed by a filter of first order. Follows interface.py. */
#include <math.h>

#include "ds_limit.h"

enum { SMOOTHED, DS_MEMORY };

#include "ds_law.h"

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    (void)value;
    (void)journal;
    return DS_OK;
}

static void begin(double memory[], const double value[])
{
    memory[SMOOTHED] = value[DS_speed_ref];
}

static void begin_change(const double value[], const double seed[], double drift[])
{
    (void)value;
    drift[SMOOTHED] = seed[DS_speed_ref];
}

static ds_result advance(double memory[], const double value[], const double slope[], double elapsed,
                         ds_journal *journal)
{
    const double asked = value[DS_speed_ref] + slope[DS_speed_ref] * elapsed;
    const double share = elapsed / (value[DS_time_constant] + elapsed);
    (void)journal;
    memory[SMOOTHED] = memory[SMOOTHED] + share * (asked - memory[SMOOTHED]);
    return DS_OK;
}

static void move(const double memory[], const double value[], double drift[])
{
    drift[SMOOTHED] = (value[DS_speed_ref] - memory[SMOOTHED]) / value[DS_time_constant];
}

static void answer(const double memory[], double value[])
{
    const double limit = value[DS_Omega_max];
    value[DS_limit_active] = fabs(memory[SMOOTHED]) > limit;
    value[DS_Omega] = ds_limited(memory[SMOOTHED], -limit, limit);
}

static void differentiate(const double memory[], const double value[], const double drift[], const double seed[],
                          double change[])
{
    const double limit = value[DS_Omega_max];
    const double change_of_limit = seed[DS_Omega_max];
    change[DS_Omega] =
        ds_limited_change(memory[SMOOTHED], drift[SMOOTHED], -limit, -change_of_limit, limit, change_of_limit);
}

static void tell_changes(const double before[], const double value[], double time, ds_journal *journal)
{
    if (value[DS_limit_active] != before[DS_limit_active]) {
        journal->event(journal->owner, time,
                       value[DS_limit_active] != 0.0 ? "Omega is held at its limit" : "Omega is off its limit again");
    }
}
