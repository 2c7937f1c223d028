/* A law of the drive's speed that `enabled` switches without a bump: while it is false, speed_ref passes through. What is
 * asked for and what is put out differ by a rest that is as large as the step which the switch would make, and dies away
 * with handover_time. The one file of such a model names the places of its memory before it includes this header,
 * `enum { DS_REST, DS_ENGAGED, FIRST, SECOND, DS_MEMORY };`, and then defines the functions declared here and
 * ds_model_check. Follows fmu_src/python/switched_law.py. */
#ifndef DS_SWITCHED_LAW_H
#define DS_SWITCHED_LAW_H

#include "ds_law.h"
#include "ds_limit.h"
#include "ds_low_pass.h"

/* fill the law's own memory from inputs and parameters at the start */
static void remember(double memory[], const double value[]);

/* go on for `elapsed` seconds, in which the inputs go from value[i] along slope[i] to end[i] */
static void go_on(double memory[], const double value[], const double slope[], const double end[], double elapsed);

/* write the derivatives of its own memory by time */
static void flow(const double memory[], const double value[], double drift[]);

/* the drive's speed that the law asks for [rad/s] */
static double ask(const double memory[], const double value[]);

/* its derivative in the direction `drift` of its own memory and `seed` of the inputs */
static double ask_change(const double memory[], const double value[], const double drift[], const double seed[]);

static void begin(double memory[], const double value[])
{
    remember(memory, value);
    memory[DS_ENGAGED] = value[DS_enabled] != 0.0;
    memory[DS_REST] = memory[DS_ENGAGED] != 0.0 ? value[DS_speed_ref] - ask(memory, value) : 0.0;
}

static void begin_change(const double value[], const double seed[], double drift[])
{
    double memory[DS_MEMORY];
    begin(memory, value);
    /* what begins at speed_ref changes with it, whatever the law would ask for */
    if (memory[DS_ENGAGED] != 0.0) {
        drift[DS_REST] = seed[DS_speed_ref] - ask_change(memory, value, drift, seed);
    }
}

static ds_result advance(double memory[], const double value[], const double slope[], double elapsed,
                         ds_journal *journal)
{
    const double enabled = value[DS_enabled] != 0.0;
    ds_answered end;
    if (ds_require_short(elapsed, journal) != DS_OK) {
        return DS_DISCARD;
    }
    ds_answered_take(&end, value, slope, elapsed);
    go_on(memory, value, slope, end.value, elapsed);
    memory[DS_REST] = memory[DS_REST] * ds_fading(elapsed, value[DS_handover_time]);
    if (enabled != memory[DS_ENGAGED]) {
        const double gap = ask(memory, end.value) - end.value[DS_speed_ref];
        memory[DS_REST] = enabled != 0.0 ? memory[DS_REST] - gap : memory[DS_REST] + gap;
    }
    memory[DS_ENGAGED] = enabled;
    return DS_OK;
}

static void move(const double memory[], const double value[], double drift[])
{
    flow(memory, value, drift);
    drift[DS_REST] = value[DS_handover_time] > 0.0 ? -memory[DS_REST] / value[DS_handover_time] : 0.0;
}

static double wanted_speed(const double memory[], const double value[])
{
    return (memory[DS_ENGAGED] != 0.0 ? ask(memory, value) : value[DS_speed_ref]) + memory[DS_REST];
}

static void answer(const double memory[], double value[])
{
    const double wanted = wanted_speed(memory, value);
    const double limit = value[DS_Omega_max];
    value[DS_limit_active] = wanted > limit || wanted < -limit;
    value[DS_Omega] = ds_limited(wanted, -limit, limit);
}

static void differentiate(const double memory[], const double value[], const double drift[], const double seed[],
                          double change[])
{
    const double limit = value[DS_Omega_max];
    const double limit_change = seed[DS_Omega_max];
    double free = memory[DS_ENGAGED] != 0.0 ? ask_change(memory, value, drift, seed) : seed[DS_speed_ref];
    free = free + drift[DS_REST];
    change[DS_Omega] = ds_limited_change(wanted_speed(memory, value), free, -limit, -limit_change, limit, limit_change);
}

static void tell_changes(const double before[], const double value[], double time, ds_journal *journal)
{
    if (value[DS_limit_active] != before[DS_limit_active]) {
        journal->event(journal->owner, time,
                       value[DS_limit_active] != 0.0 ? "Omega is held at its limit" : "Omega is off its limit again");
    }
}

#endif
