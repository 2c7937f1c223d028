/* A value sent from downhole in frames of bits. Follows models/controllers/telemetry.py, which explains it. */
#include <math.h>
#include <stdio.h>

#include "ds_noise.h"
#include "ds_number.h"

#define UNDER_WAY 256
#define MOST_FRAMES 1e6
#define ON_TIME 1e-6
#define ROUNDING 1e-13
#define LOST (-1.0)

enum { CLOCK, SENT, DUE, MEASURED, STAMP, LIMITED, RANDOM, CODES, DS_MEMORY = CODES + UNDER_WAY };

#include "ds_law.h"

enum { LINK_MUD_PULSE = 1, LINK_WIRED_PIPE = 2, LINK_OWN = 3 };

typedef struct {
    double interval; /* between frames, s */
    double latency;  /* from a sample to its arrival, s */
    double steps;    /* quanta in the range */
} frames;

static frames frames_of(const double value[])
{
    const int link = (int)value[DS_link];
    const double rate = link == LINK_MUD_PULSE ? 10.0 : link == LINK_WIRED_PIPE ? 57600.0 : value[DS_bit_rate];
    const double transport = link == LINK_MUD_PULSE    ? value[DS_L] / 1200.0
                             : link == LINK_WIRED_PIPE ? 0.0
                                                       : value[DS_L] / value[DS_wave_speed];
    const double frame = (value[DS_bits] + value[DS_overhead]) / rate;
    double steps = 1.0;
    for (int i = 0; i < (int)value[DS_bits]; ++i) {
        steps = steps * 2.0;
    }
    const frames of = {value[DS_sample_time] > frame ? value[DS_sample_time] : frame, frame + transport, steps - 1.0};
    return of;
}

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    const frames of = frames_of(value);
    if (of.latency > (UNDER_WAY - 2) * of.interval) {
        snprintf(journal->reason, sizeof journal->reason,
                 "a frame takes %s s to arrive; expected at most 254 times the time between frames, %s s",
                 ds_number(of.latency).text, ds_number((UNDER_WAY - 2) * of.interval).text);
        return DS_DISCARD;
    }
    return DS_OK;
}

static void take_sample(double memory[], const double value[], frames of, double sampled)
{
    double code = (sampled - value[DS_value_min]) / value[DS_range] * of.steps;
    code = code > of.steps ? of.steps : code < 0.0 ? 0.0 : (double)(int)(code + 0.5);
    const double drawn = ds_uniform(&memory[RANDOM]);
    memory[CODES + (int)fmod(memory[SENT], UNDER_WAY)] = drawn < value[DS_loss] ? LOST : code;
    memory[SENT] = memory[SENT] + 1.0;
}

static void arrive(double memory[], const double value[], frames of)
{
    const double code = memory[CODES + (int)fmod(memory[DUE], UNDER_WAY)];
    const double stamp = memory[DUE] * of.interval;
    memory[DUE] = memory[DUE] + 1.0;
    if (code != LOST) {
        memory[MEASURED] = value[DS_value_min] + value[DS_range] * (code / of.steps);
        memory[STAMP] = stamp;
        memory[LIMITED] = code == 0.0 || code == of.steps;
    }
}

static void begin(double memory[], const double value[])
{
    for (int i = 0; i < DS_MEMORY; ++i) {
        memory[i] = 0.0;
    }
    memory[MEASURED] = value[DS_value_min];
    memory[STAMP] = -1.0;
    memory[RANDOM] = value[DS_seed];
    take_sample(memory, value, frames_of(value), value[DS_value]);
}

static void begin_change(const double value[], const double seed[], double drift[])
{
    (void)value;
    drift[MEASURED] = seed[DS_value_min];
}

static ds_result advance(double memory[], const double value[], const double slope[], double elapsed,
                         ds_journal *journal)
{
    const frames of = frames_of(value);
    const double start = memory[CLOCK];
    const double end = start + elapsed;
    const double late = end + (ON_TIME * of.interval + ROUNDING * end);
    if (elapsed > MOST_FRAMES * of.interval) {
        snprintf(journal->reason, sizeof journal->reason, "a step of %s s has more than 1e+06 frames; expected fewer",
                 ds_number(elapsed).text);
        return DS_DISCARD;
    }
    for (;;) {
        const double sample = memory[SENT] * of.interval;
        const double arrival = memory[DUE] * of.interval + of.latency;
        const int waits = memory[DUE] < memory[SENT];
        if (waits && arrival <= sample && arrival <= late) {
            arrive(memory, value, of);
        } else if (sample <= late) {
            take_sample(memory, value, of, value[DS_value] + slope[DS_value] * (sample - start));
        } else if (waits && arrival <= late) {
            arrive(memory, value, of);
        } else {
            memory[CLOCK] = end;
            return DS_OK;
        }
    }
}

static void move(const double memory[], const double value[], double drift[])
{
    (void)memory;
    (void)value;
    drift[CLOCK] = 1.0;
}

static void answer(const double memory[], double value[])
{
    const frames of = frames_of(value);
    const double last = (memory[DUE] - 1.0) * of.interval;
    value[DS_measured] = memory[MEASURED];
    value[DS_age] = memory[STAMP] >= 0.0 ? memory[CLOCK] - memory[STAMP] : memory[CLOCK];
    value[DS_valid] = memory[STAMP] >= 0.0 && last <= memory[STAMP] + ON_TIME * of.interval;
    value[DS_limit_active] = memory[LIMITED];
}

static void differentiate(const double memory[], const double value[], const double drift[], const double seed[],
                          double change[])
{
    (void)memory;
    (void)value;
    (void)seed;
    change[DS_measured] = drift[MEASURED];
    change[DS_age] = drift[CLOCK];
}

static void tell_changes(const double before[], const double value[], double time, ds_journal *journal)
{
    if (value[DS_valid] != before[DS_valid]) {
        journal->event(journal->owner, time, value[DS_valid] != 0.0 ? "values arrive" : "a frame is lost");
    }
}
