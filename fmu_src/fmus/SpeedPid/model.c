/* PI and PID control of the rotor's speed. Follows models/controllers/speed_pid.py, which explains it. */
#include <stdio.h>

#include "ds_limit.h"
#include "ds_low_pass.h"
#include "ds_number.h"
#include "ds_stick_slip.h"

enum { SET_POINT, SUM, SMOOTHED, ENGAGED, FREQUENCY, DS_MEMORY };

#include "ds_law.h"

enum { MODE_TUNED = 1, MODE_STIFF = 2, MODE_OWN = 3 };

typedef struct {
    double proportional; /* N m s/rad */
    double integral;     /* N m/rad */
    double derivative;   /* N m s^2/rad */
} pid_gains;

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    if (value[DS_torque_max] < value[DS_torque_min]) {
        snprintf(journal->reason, sizeof journal->reason, "torque_max is %s; expected at least torque_min = %s",
                 ds_number(value[DS_torque_max]).text, ds_number(value[DS_torque_min]).text);
        return DS_DISCARD;
    }
    return DS_OK;
}

/* switched off, the gains are those of an ordinary drive */
static pid_gains gains_of(const double memory[], const double value[], int engaged)
{
    const int mode = engaged ? (int)value[DS_mode] : MODE_STIFF;
    const double impedance = ds_impedance(value);
    const double frequency = memory[FREQUENCY];
    const pid_gains stiff = {50.0 * impedance, 5.0 * value[DS_J_r], 0.0};
    const pid_gains tuned = {4.0 * impedance, frequency * frequency * value[DS_J_r], 0.0};
    const pid_gains own = {value[DS_K_p], value[DS_K_i], value[DS_K_d]};
    return mode == MODE_STIFF ? stiff : mode == MODE_TUNED ? tuned : own;
}

static double wanted_torque(const double memory[], const double value[], pid_gains gains, double speed)
{
    const double hold = gains.derivative * ((speed - memory[SMOOTHED]) / value[DS_filter_time]);
    return gains.proportional * (memory[SET_POINT] - speed) + memory[SUM] - hold;
}

static void begin(double memory[], const double value[])
{
    memory[SET_POINT] = value[DS_Omega];
    memory[SUM] = value[DS_torque_initial];
    memory[SMOOTHED] = value[DS_Omega];
    memory[ENGAGED] = value[DS_enabled] != 0.0;
    memory[FREQUENCY] = ds_stick_slip_frequency(value);
}

static void begin_change(const double value[], const double seed[], double drift[])
{
    (void)value;
    drift[SET_POINT] = seed[DS_Omega];
    drift[SUM] = seed[DS_torque_initial];
    drift[SMOOTHED] = seed[DS_Omega];
}

static ds_result advance(double memory[], const double value[], const double slope[], double elapsed,
                         ds_journal *journal)
{
    const int enabled = value[DS_enabled] != 0.0;
    const pid_gains gains = gains_of(memory, value, memory[ENGAGED] != 0.0);
    const double speed = value[DS_Omega];
    const double end = speed + slope[DS_Omega] * elapsed;
    const double most = value[DS_rate_limit] * elapsed;
    const double asked = value[DS_speed_ref] + slope[DS_speed_ref] * elapsed;
    const double before = memory[SET_POINT];
    const double sum = memory[SUM];
    if (ds_require_short(elapsed, journal) != DS_OK) {
        return DS_DISCARD;
    }
    memory[SET_POINT] = before + ds_limited(asked - before, -most, most);
    memory[SMOOTHED] = ds_low_pass(memory[SMOOTHED], speed, slope[DS_Omega], elapsed, value[DS_filter_time]);
    const double error = memory[SET_POINT] - end;
    const double middle = ((before - speed) + error) * 0.5;
    memory[SUM] = sum + gains.integral * elapsed * middle;
    const double wanted = wanted_torque(memory, value, gains, end);
    /* what would drive the torque further beyond its limit is not added up */
    if ((wanted > value[DS_torque_max] && error > 0.0) || (wanted < value[DS_torque_min] && error < 0.0)) {
        memory[SUM] = sum;
    }
    if (enabled != (memory[ENGAGED] != 0.0)) {
        const pid_gains after = gains_of(memory, value, enabled);
        const double gap = wanted_torque(memory, value, gains, end) - wanted_torque(memory, value, after, end);
        memory[SUM] = memory[SUM] + gap;
        memory[ENGAGED] = enabled;
    }
    return DS_OK;
}

static void move(const double memory[], const double value[], double drift[])
{
    const pid_gains gains = gains_of(memory, value, memory[ENGAGED] != 0.0);
    const double error = memory[SET_POINT] - value[DS_Omega];
    const double gap = value[DS_speed_ref] - memory[SET_POINT];
    const double wanted = wanted_torque(memory, value, gains, value[DS_Omega]);
    const int held = (wanted > value[DS_torque_max] && error > 0.0) || (wanted < value[DS_torque_min] && error < 0.0);
    drift[SET_POINT] = gap > 0.0 ? value[DS_rate_limit] : gap < 0.0 ? -value[DS_rate_limit] : 0.0;
    drift[SUM] = held ? 0.0 : gains.integral * error;
    drift[SMOOTHED] = (value[DS_Omega] - memory[SMOOTHED]) / value[DS_filter_time];
}

static void answer(const double memory[], double value[])
{
    const pid_gains gains = gains_of(memory, value, memory[ENGAGED] != 0.0);
    const double wanted = wanted_torque(memory, value, gains, value[DS_Omega]);
    value[DS_motor_torque] = ds_limited(wanted, value[DS_torque_min], value[DS_torque_max]);
    value[DS_limit_active] = wanted > value[DS_torque_max] || wanted < value[DS_torque_min];
}

static void differentiate(const double memory[], const double value[], const double drift[], const double seed[],
                          double change[])
{
    const pid_gains gains = gains_of(memory, value, memory[ENGAGED] != 0.0);
    const double wanted = wanted_torque(memory, value, gains, value[DS_Omega]);
    const double hold = gains.derivative * ((seed[DS_Omega] - drift[SMOOTHED]) / value[DS_filter_time]);
    const double free = gains.proportional * (drift[SET_POINT] - seed[DS_Omega]) + drift[SUM] - hold;
    change[DS_motor_torque] = ds_limited_change(wanted, free, value[DS_torque_min], seed[DS_torque_min],
                                                value[DS_torque_max], seed[DS_torque_max]);
}

static void tell_changes(const double before[], const double value[], double time, ds_journal *journal)
{
    if (value[DS_limit_active] != before[DS_limit_active]) {
        journal->event(journal->owner, time, value[DS_limit_active] != 0.0 ? "motor_torque is held at its limit"
                                                                           : "motor_torque is off its limit again");
    }
}
