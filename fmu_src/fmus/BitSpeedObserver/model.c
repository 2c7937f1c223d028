/* Bit speed and torque from the top of the string. Follows models/controllers/observer.py, which explains it. */
#include <math.h>

#include "ds_low_pass.h"
#include "ds_stick_slip.h"

#define ROOM 1032
#define SPACING 1000.0
#define STEEPER 4.0
#define ON_TIME 1e-9

/* samples are kept in a ring, from place FIRST on */
enum {
    CLOCK,
    UP,
    UP_CHANGE,
    DELAYED,
    KNOWN,
    SMOOTH_SPEED,
    SMOOTH_TORQUE,
    FIRST,
    COUNT,
    TIMES,
    DOWNS = TIMES + ROOM,
    JUMPS = DOWNS + ROOM,
    CHANGES = JUMPS + ROOM,
    DS_MEMORY = CHANGES + ROOM
};

#include "ds_law.h"

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    (void)value;
    (void)journal;
    return DS_OK;
}

/* the wave that comes up, and the one sent down, of speed and torque or of their derivatives */
static double up_of(const double value[], double impedance)
{
    return (value[DS_top_speed] - value[DS_top_torque] / impedance) * 0.5;
}

static double down_of(const double value[], double impedance)
{
    return (value[DS_top_speed] + value[DS_top_torque] / impedance) * 0.5;
}

/* place of the sample with a number, the oldest being 0 */
static int place_of(const double memory[], int number)
{
    return ((int)memory[FIRST] + number) % ROOM;
}

static int jumps(const double value[], double change, double before)
{
    const double size = change >= 0.0 ? change : -change;
    const double least = STEEPER * (before >= 0.0 ? before : -before);
    return size > value[DS_jump] && size > least;
}

static void put_sample(double memory[], int place, double time, double down, int jumped, double change)
{
    memory[TIMES + place] = time;
    memory[DOWNS + place] = down;
    memory[JUMPS + place] = jumped;
    memory[CHANGES + place] = change;
}

static void keep_sample(double memory[], const double value[], double down, double late)
{
    const int count = (int)memory[COUNT];
    const int last = place_of(memory, count - 1);
    const double change = down - memory[DOWNS + last];
    const int jumped = memory[CHANGES + last] != 0.0 && jumps(value, change, memory[CHANGES + last]);
    if (count > 1) {
        const int before = place_of(memory, count - 2);
        if (memory[TIMES + last] - memory[TIMES + before] < late / SPACING * (1.0 - ON_TIME)) {
            put_sample(memory, last, memory[CLOCK], down, jumped || memory[JUMPS + last] != 0.0,
                       down - memory[DOWNS + before]);
            return;
        }
    }
    put_sample(memory, place_of(memory, count), memory[CLOCK], down, jumped, change);
    memory[COUNT] = count + 1;
}

static void forget_samples(double memory[], double target)
{
    while (memory[COUNT] > 3.0 && memory[TIMES + place_of(memory, 2)] <= target) {
        memory[FIRST] = place_of(memory, 1);
        memory[COUNT] = memory[COUNT] - 1.0;
    }
}

static void begin(double memory[], const double value[])
{
    const double impedance = ds_impedance(value);
    for (int i = 0; i < DS_MEMORY; ++i) {
        memory[i] = 0.0;
    }
    memory[UP] = up_of(value, impedance);
    memory[DELAYED] = down_of(value, impedance);
    memory[SMOOTH_SPEED] = value[DS_top_speed];
    memory[SMOOTH_TORQUE] = value[DS_top_torque];
    memory[COUNT] = 1.0;
    put_sample(memory, 0, 0.0, memory[DELAYED], 0, 0.0);
}

static void begin_change(const double value[], const double seed[], double drift[])
{
    drift[DELAYED] = down_of(seed, ds_impedance(value));
    drift[SMOOTH_SPEED] = seed[DS_top_speed];
    drift[SMOOTH_TORQUE] = seed[DS_top_torque];
}

static ds_result advance(double memory[], const double value[], const double slope[], double elapsed,
                         ds_journal *journal)
{
    const double impedance = ds_impedance(value);
    const double late = 2.0 * (value[DS_L] * sqrt(value[DS_I] / (value[DS_G] * value[DS_J])));
    ds_answered end;
    if (ds_require_short(elapsed, journal) != DS_OK) {
        return DS_DISCARD;
    }
    ds_answered_take(&end, value, slope, elapsed);
    memory[CLOCK] = memory[CLOCK] + elapsed;
    const double up = up_of(end.value, impedance);
    const double target = memory[CLOCK] - late;
    keep_sample(memory, value, down_of(end.value, impedance), late);
    forget_samples(memory, target);
    const int number = memory[COUNT] > 2.0 && memory[TIMES + place_of(memory, 1)] <= target ? 1 : 0;
    const int first = place_of(memory, number);
    const int second = place_of(memory, number + 1);
    memory[DELAYED] = memory[DOWNS + first];
    if (target > memory[TIMES + first]) {
        const double share = (target - memory[TIMES + first]) / (memory[TIMES + second] - memory[TIMES + first]);
        memory[DELAYED] = memory[DOWNS + first] + share * (memory[DOWNS + second] - memory[DOWNS + first]);
    }
    const double change = up - memory[UP];
    int jumped = jumps(value, change, memory[UP_CHANGE]) || memory[JUMPS + first] != 0.0 || memory[JUMPS + second] != 0.0;
    if (memory[COUNT] > number + 2 && memory[JUMPS + place_of(memory, number + 2)] != 0.0) {
        jumped = 1;
    }
    const int known = target >= memory[TIMES + place_of(memory, 0)] - ON_TIME * late
                      && memory[CLOCK] >= late * (1.0 - ON_TIME);
    const double found = up + memory[DELAYED];
    const double pull = impedance * (memory[DELAYED] - up);
    memory[SMOOTH_SPEED] = ds_low_pass(memory[SMOOTH_SPEED], found, 0.0, elapsed, value[DS_filter_time]);
    memory[SMOOTH_TORQUE] = ds_low_pass(memory[SMOOTH_TORQUE], pull, 0.0, elapsed, value[DS_filter_time]);
    memory[UP] = up;
    memory[UP_CHANGE] = change;
    memory[KNOWN] = known && !jumped;
    return DS_OK;
}

/* the outputs are held from one communication point to the next */
static void move(const double memory[], const double value[], double drift[])
{
    (void)memory;
    (void)value;
    (void)drift;
}

static void answer(const double memory[], double value[])
{
    const double found = memory[UP] + memory[DELAYED];
    value[DS_bit_speed] = found;
    value[DS_string_torque] = ds_impedance(value) * (memory[DELAYED] - memory[UP]);
    value[DS_bit_torque] =
        memory[SMOOTH_TORQUE] - value[DS_I_B] * ((found - memory[SMOOTH_SPEED]) / value[DS_filter_time]);
    value[DS_valid] = memory[KNOWN];
}

static void differentiate(const double memory[], const double value[], const double drift[], const double seed[],
                          double change[])
{
    const double impedance = ds_impedance(value);
    const double up = up_of(seed, impedance);
    const double found = up + drift[DELAYED];
    (void)memory;
    change[DS_bit_speed] = found;
    change[DS_string_torque] = impedance * (drift[DELAYED] - up);
    change[DS_bit_torque] =
        drift[SMOOTH_TORQUE] - value[DS_I_B] * ((found - drift[SMOOTH_SPEED]) / value[DS_filter_time]);
}

static void tell_changes(const double before[], const double value[], double time, ds_journal *journal)
{
    (void)before;
    (void)value;
    (void)time;
    (void)journal;
}
