/* A supervisor of stick-slip. Follows models/controllers/supervisor.py, which explains it. */
#include <math.h>
#include <stdio.h>

#include "ds_number.h"

#define BINS 40
#define MOST_PARTS 1e4
#define ON_TIME 1e-6
#define ROUNDING 1e-13

enum {
    CLOCK,
    PARTS,
    LOW,
    HIGH,
    TURNED,
    SEVERITY,
    SPEED,
    DECISIONS,
    LIMITED,
    LOWS,
    HIGHS = LOWS + BINS,
    ANGLES = HIGHS + BINS,
    DS_MEMORY = ANGLES + BINS
};

#include "ds_law.h"

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    if (value[DS_speed_initial] > value[DS_speed_max]) {
        snprintf(journal->reason, sizeof journal->reason, "speed_initial is %s; expected at most speed_max, %s",
                 ds_number(value[DS_speed_initial]).text, ds_number(value[DS_speed_max]).text);
        return DS_DISCARD;
    }
    return DS_OK;
}

static void begin(double memory[], const double value[])
{
    for (int i = 0; i < DS_MEMORY; ++i) {
        memory[i] = 0.0;
    }
    memory[LOW] = value[DS_bit_speed];
    memory[HIGH] = value[DS_bit_speed];
    memory[SPEED] = value[DS_speed_initial];
}

static void begin_change(const double value[], const double seed[], double drift[])
{
    (void)value;
    drift[SPEED] = seed[DS_speed_initial];
}

/* count a straight line of speed among the part of the window that is not complete */
static void take(double memory[], double first, double last, double duration)
{
    memory[LOW] = first < memory[LOW] ? first : memory[LOW];
    memory[LOW] = last < memory[LOW] ? last : memory[LOW];
    memory[HIGH] = first > memory[HIGH] ? first : memory[HIGH];
    memory[HIGH] = last > memory[HIGH] ? last : memory[HIGH];
    memory[TURNED] = memory[TURNED] + 0.5 * (first + last) * duration;
}

/* (max - min) / (2 mean) of the window, at most severity_max, which is told too where the bit does not turn */
static double severity_of(const double memory[], const double value[])
{
    double low = memory[LOWS];
    double high = memory[HIGHS];
    double turned = 0.0;
    for (int i = 0; i < BINS; ++i) {
        low = memory[LOWS + i] < low ? memory[LOWS + i] : low;
        high = memory[HIGHS + i] > high ? memory[HIGHS + i] : high;
        turned = turned + memory[ANGLES + i];
    }
    const double twice = 2.0 * (turned / value[DS_window]);
    const double swing = high - low;
    return twice > 0.0 && swing <= value[DS_severity_max] * twice ? swing / twice : value[DS_severity_max];
}

/* take up the next part of the window, which begins at a speed, and measure if a window is complete */
static void close_part(double memory[], const double value[], double last)
{
    const int place = (int)fmod(memory[PARTS], BINS);
    memory[LOWS + place] = memory[LOW];
    memory[HIGHS + place] = memory[HIGH];
    memory[ANGLES + place] = memory[TURNED];
    memory[PARTS] = memory[PARTS] + 1.0;
    memory[SEVERITY] = memory[PARTS] >= BINS ? severity_of(memory, value) : 0.0;
    memory[LOW] = last;
    memory[HIGH] = last;
    memory[TURNED] = 0.0;
}

static void decide(double memory[], const double value[])
{
    const int raised = value[DS_enabled] != 0.0 && value[DS_valid] != 0.0 && value[DS_measured] > value[DS_threshold];
    const double wanted = raised ? memory[SPEED] + value[DS_speed_step] : memory[SPEED];
    memory[LIMITED] = wanted > value[DS_speed_max];
    memory[SPEED] = memory[LIMITED] != 0.0 ? value[DS_speed_max] : wanted;
    memory[DECISIONS] = memory[DECISIONS] + 1.0;
}

static ds_result advance(double memory[], const double value[], const double slope[], double elapsed,
                         ds_journal *journal)
{
    const double width = value[DS_window] / BINS;
    const double least = width < value[DS_interval] ? width : value[DS_interval];
    const double start = memory[CLOCK];
    const double end = start + elapsed;
    const double speed = value[DS_bit_speed];
    double at = start;
    double late = end + (ON_TIME * width + ROUNDING * end);
    if (elapsed > MOST_PARTS * least) {
        snprintf(journal->reason, sizeof journal->reason, "a step of %s s cannot be followed; expected at most %s s",
                 ds_number(elapsed).text, ds_number(MOST_PARTS * least).text);
        return DS_DISCARD;
    }
    while ((memory[PARTS] + 1.0) * width <= late) {
        const double boundary = (memory[PARTS] + 1.0) * width;
        const double last = speed + slope[DS_bit_speed] * (boundary - start);
        take(memory, speed + slope[DS_bit_speed] * (at - start), last, boundary - at);
        close_part(memory, value, last);
        at = boundary;
    }
    if (end > at) {
        take(memory, speed + slope[DS_bit_speed] * (at - start), speed + slope[DS_bit_speed] * elapsed, end - at);
    }
    late = end + (ON_TIME * value[DS_interval] + ROUNDING * end);
    while ((memory[DECISIONS] + 1.0) * value[DS_interval] <= late) {
        decide(memory, value);
    }
    memory[CLOCK] = end;
    return DS_OK;
}

static void move(const double memory[], const double value[], double drift[])
{
    (void)memory;
    (void)value;
    drift[CLOCK] = 1.0;
}

static void answer(const double memory[], double value[])
{
    value[DS_severity] = memory[SEVERITY];
    value[DS_speed_ref] = memory[SPEED];
    value[DS_limit_active] = memory[LIMITED];
}

static void differentiate(const double memory[], const double value[], const double drift[], const double seed[],
                          double change[])
{
    (void)memory;
    (void)value;
    (void)seed;
    change[DS_speed_ref] = drift[SPEED];
}

static void tell_changes(const double before[], const double value[], double time, ds_journal *journal)
{
    if (value[DS_speed_ref] > before[DS_speed_ref]) {
        journal->event(journal->owner, time, "the speed is raised");
    }
    if (value[DS_limit_active] != 0.0 && before[DS_limit_active] == 0.0) {
        journal->event(journal->owner, time, "the speed is held at its limit");
    }
}
