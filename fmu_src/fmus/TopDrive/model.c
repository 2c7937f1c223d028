/* A rotary drive with lag, inertia, limits, sampling and noise. Follows models/controllers/top_drive.py, which explains
 * it. */
#include <math.h>
#include <stdio.h>

#include "ds_limit.h"
#include "ds_low_pass.h"
#include "ds_noise.h"
#include "ds_number.h"

#define LONGEST_QUEUE 64
#define MOST_SAMPLES 1e6
#define ON_TIME 1e-6

enum {
    DRIVE_SPEED,
    MOTOR,
    COMMAND,
    INTEGRAL,
    LEFT,
    LIMITED, /* 1 at the greatest torque or power, -1 at the least, else 0 */
    OVER,    /* by how much a drive of mode speed, at its least torque, is faster than asked for */
    RANDOM,
    SEEN_SPEED,
    SEEN_TORQUE,
    SEEN_TOP,
    PLACE,
    RATE, /* of Omega, from the left: a sample at the end of a step has not acted yet */
    QUEUE,
    DS_MEMORY = QUEUE + LONGEST_QUEUE
};

#include "ds_law.h"

enum { MODE_SPEED = 1, MODE_SERVO = 2, MODE_TORQUE = 3 };

static int mode_of(const double value[])
{
    return (int)value[DS_mode];
}

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    const double most = LONGEST_QUEUE * value[DS_sample_time];
    if (value[DS_delay] > most) {
        snprintf(journal->reason, sizeof journal->reason, "delay is %s s; expected at most 64 sample times, %s s",
                 ds_number(value[DS_delay]).text, ds_number(most).text);
        return DS_DISCARD;
    }
    return DS_OK;
}

static double highest_at(const double value[], double speed)
{
    const double size = speed >= 0.0 ? speed : -speed;
    return size * value[DS_torque_max] > value[DS_power_max] ? value[DS_power_max] / size : value[DS_torque_max];
}

static double turning(const double memory[])
{
    return memory[DRIVE_SPEED] + memory[OVER];
}

/* 1 if more was asked of the motor than it gives, -1 if less, else 0 */
static double beyond(double asked, double motor)
{
    return asked > motor ? 1.0 : asked < motor ? -1.0 : 0.0;
}

/* what the motor is asked for at the start */
static int asked_at_start(const double value[])
{
    return mode_of(value) == MODE_TORQUE ? DS_motor_torque : DS_top_torque;
}

/* derivative of Omega while the motor and the command are as they are */
static double rate_of(const double memory[], const double value[], double torque)
{
    const double rate = value[DS_rate_limit];
    const double gap = memory[COMMAND] - memory[DRIVE_SPEED];
    const double rotor = (memory[MOTOR] - torque) / value[DS_J_r];
    double following = gap > 0.0 ? rate : gap < 0.0 ? -rate : 0.0;
    if (value[DS_lag] > 0.0) {
        following = ds_limited(gap / value[DS_lag], -rate, rate);
    }
    if (mode_of(value) != MODE_SPEED || memory[OVER] > 0.0) {
        return rotor;
    }
    if (memory[LIMITED] > 0.0) {
        return fmin(following, rotor);
    }
    return memory[LIMITED] < 0.0 ? fmax(following, rotor) : following;
}

static void begin(double memory[], const double value[])
{
    const double asked = value[asked_at_start(value)];
    const double motor = ds_limited(asked, value[DS_torque_min], highest_at(value, value[DS_Omega_command]));
    const double command = mode_of(value) == MODE_TORQUE ? value[DS_motor_torque] : value[DS_Omega_command];
    memory[DRIVE_SPEED] = value[DS_Omega_command];
    memory[MOTOR] = motor;
    memory[COMMAND] = value[DS_Omega_command];
    memory[INTEGRAL] = motor;
    memory[LEFT] = value[DS_sample_time];
    memory[LIMITED] = beyond(asked, motor);
    memory[OVER] = 0.0;
    memory[RANDOM] = value[DS_seed];
    memory[SEEN_SPEED] = value[DS_Omega_command];
    memory[SEEN_TORQUE] = value[DS_top_torque];
    memory[SEEN_TOP] = value[DS_top_speed];
    memory[PLACE] = 0.0;
    memory[RATE] = rate_of(memory, value, value[DS_top_torque]);
    for (int i = 0; i < LONGEST_QUEUE; ++i) {
        memory[QUEUE + i] = command;
    }
}

static void begin_change(const double value[], const double seed[], double drift[])
{
    const int asked = asked_at_start(value);
    const double speed = value[DS_Omega_command];
    const double highest = highest_at(value, speed);
    double change = seed[DS_torque_max];
    if (fabs(speed) * value[DS_torque_max] > value[DS_power_max]) {
        change = (seed[DS_power_max] - highest * copysign(1.0, speed) * seed[DS_Omega_command]) / fabs(speed);
    }
    drift[DRIVE_SPEED] = seed[DS_Omega_command];
    drift[SEEN_SPEED] = seed[DS_Omega_command];
    drift[SEEN_TORQUE] = seed[DS_top_torque];
    drift[SEEN_TOP] = seed[DS_top_speed];
    drift[MOTOR] = ds_limited_change(value[asked], seed[asked], value[DS_torque_min], seed[DS_torque_min], highest, change);
}

static double followed(const double value[], double speed, double command, double part)
{
    const double rate = value[DS_rate_limit];
    const double lag = value[DS_lag];
    const double reach = rate * lag;
    double gap = command - speed;
    if (gap > reach || gap < -reach) {
        const double climb = gap > 0.0 ? rate : -rate;
        const double until = (gap - climb * lag) / climb;
        if (until >= part) {
            return speed + climb * part;
        }
        gap = climb * lag;
        part = part - until;
    }
    return command - gap * ds_fading(part, lag);
}

static void go_between(double memory[], const double value[], const double slope[], double done, double part)
{
    const double torque = value[DS_top_torque] + slope[DS_top_torque] * (done + 0.5 * part);
    const double turned = turning(memory) + part * (memory[MOTOR] - torque) / value[DS_J_r];
    if (mode_of(value) != MODE_SPEED) {
        memory[DRIVE_SPEED] = turned;
        return;
    }
    const double speed = followed(value, memory[DRIVE_SPEED], memory[COMMAND], part);
    if (memory[LIMITED] > 0.0) {
        memory[DRIVE_SPEED] = turned < speed ? turned : speed;
        return;
    }
    memory[OVER] = memory[LIMITED] < 0.0 && turned > speed ? turned - speed : 0.0;
    memory[DRIVE_SPEED] = speed;
}

static double at(const double value[], const double slope[], int which, double elapsed)
{
    return value[which] + slope[which] * elapsed;
}

static void read_sensors(double memory[], const double value[], const double slope[], double elapsed)
{
    memory[SEEN_SPEED] = turning(memory);
    memory[SEEN_TORQUE] = at(value, slope, DS_top_torque, elapsed);
    memory[SEEN_TOP] = at(value, slope, DS_top_speed, elapsed);
    if (value[DS_speed_noise] > 0.0) {
        memory[SEEN_SPEED] = memory[SEEN_SPEED] + value[DS_speed_noise] * ds_normal(&memory[RANDOM]);
        memory[SEEN_TOP] = memory[SEEN_TOP] + value[DS_speed_noise] * ds_normal(&memory[RANDOM]);
    }
    if (value[DS_torque_noise] > 0.0) {
        memory[SEEN_TORQUE] = memory[SEEN_TORQUE] + value[DS_torque_noise] * ds_normal(&memory[RANDOM]);
    }
}

/* the command that arrives as another sets out */
static double arrived(double memory[], const double value[], double command)
{
    const int length = (int)(value[DS_delay] / value[DS_sample_time] + 0.5);
    if (length == 0) {
        return command;
    }
    const int place = (int)memory[PLACE];
    const double asked = memory[QUEUE + place];
    memory[QUEUE + place] = command;
    memory[PLACE] = (place + 1) % length;
    return asked;
}

/* the motor gives what the string takes, as far as it can; beyond, the speed is that of the rotor */
static void strain(double memory[], const double value[], double asked, double torque, double highest)
{
    const int loose = torque < value[DS_torque_min] || memory[OVER] > 0.0;
    memory[COMMAND] = asked;
    memory[MOTOR] = loose ? value[DS_torque_min] : ds_limited(torque, value[DS_torque_min], highest);
    memory[LIMITED] = loose ? -1.0 : beyond(torque, memory[MOTOR]);
}

static void control_speed(double memory[], const double value[], double asked, double highest)
{
    const double most = value[DS_rate_limit] * value[DS_sample_time];
    memory[COMMAND] = memory[COMMAND] + ds_limited(asked - memory[COMMAND], -most, most);
    const double error = memory[COMMAND] - memory[SEEN_SPEED];
    const double integral = memory[INTEGRAL] + value[DS_K_i] * value[DS_sample_time] * error;
    const double wanted = value[DS_K_p] * error + integral;
    memory[MOTOR] = ds_limited(wanted, value[DS_torque_min], highest);
    memory[LIMITED] = beyond(wanted, memory[MOTOR]);
    /* what would drive the torque further beyond its limit is not added up */
    if (!((wanted > highest && error > 0.0) || (wanted < value[DS_torque_min] && error < 0.0))) {
        memory[INTEGRAL] = integral;
    }
}

static void take_sample(double memory[], const double value[], const double slope[], double elapsed)
{
    const int mode = mode_of(value);
    read_sensors(memory, value, slope, elapsed);
    const double given = at(value, slope, mode == MODE_TORQUE ? DS_motor_torque : DS_Omega_command, elapsed);
    const double asked = arrived(memory, value, given);
    const double highest = highest_at(value, turning(memory));
    memory[LEFT] = value[DS_sample_time];
    if (mode == MODE_SPEED) {
        strain(memory, value, asked, at(value, slope, DS_top_torque, elapsed), highest);
    } else if (mode == MODE_SERVO) {
        control_speed(memory, value, asked, highest);
    } else {
        memory[MOTOR] = ds_limited(asked, value[DS_torque_min], highest);
        memory[LIMITED] = beyond(asked, memory[MOTOR]);
    }
}

static ds_result advance(double memory[], const double value[], const double slope[], double elapsed,
                         ds_journal *journal)
{
    double done = 0.0;
    if (elapsed > MOST_SAMPLES * value[DS_sample_time]) {
        snprintf(journal->reason, sizeof journal->reason, "a step of %s s has more than 1e+06 samples; expected fewer",
                 ds_number(elapsed).text);
        return DS_DISCARD;
    }
    while (elapsed - done >= memory[LEFT] - ON_TIME * value[DS_sample_time]) {
        const double part = memory[LEFT];
        go_between(memory, value, slope, done, part);
        memory[RATE] = rate_of(memory, value, at(value, slope, DS_top_torque, done + part));
        take_sample(memory, value, slope, done + part);
        done = done + part;
    }
    const double rest = elapsed - done;
    if (rest > 0.0) {
        go_between(memory, value, slope, done, rest);
        memory[RATE] = rate_of(memory, value, at(value, slope, DS_top_torque, elapsed));
    }
    memory[LEFT] = memory[LEFT] - rest;
    return DS_OK;
}

static void move(const double memory[], const double value[], double drift[])
{
    (void)value;
    drift[DRIVE_SPEED] = memory[RATE];
}

static void answer(const double memory[], double value[])
{
    value[DS_Omega] = turning(memory);
    value[DS_motor_torque_applied] = memory[MOTOR];
    value[DS_limit_active] = memory[LIMITED] != 0.0;
    value[DS_Omega_measured] = memory[SEEN_SPEED];
    value[DS_top_torque_measured] = memory[SEEN_TORQUE];
    value[DS_top_speed_measured] = memory[SEEN_TOP];
}

static void differentiate(const double memory[], const double value[], const double drift[], const double seed[],
                          double change[])
{
    (void)memory;
    (void)value;
    (void)seed;
    change[DS_Omega] = drift[DRIVE_SPEED];
    change[DS_motor_torque_applied] = drift[MOTOR];
    change[DS_Omega_measured] = drift[SEEN_SPEED];
    change[DS_top_torque_measured] = drift[SEEN_TORQUE];
    change[DS_top_speed_measured] = drift[SEEN_TOP];
}

static void tell_changes(const double before[], const double value[], double time, ds_journal *journal)
{
    if (value[DS_limit_active] != before[DS_limit_active]) {
        journal->event(journal->owner, time, value[DS_limit_active] != 0.0 ? "torque or power of the motor is at its limit"
                                                                           : "the motor is off its limits again");
    }
}
