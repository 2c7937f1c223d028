/* A drive that meets the string as a damper, a spring and a mass do. Follows models/controllers/virtual_drive.py, which
 * explains it. The model that includes this has the inputs top_speed, top_torque and speed_ref and the parameters of the
 * string, filter_time, slip_time and slip (1: mean, 2: compensated). */
#ifndef DS_VIRTUAL_DRIVE_H
#define DS_VIRTUAL_DRIVE_H

#include "ds_low_pass.h"
#include "ds_stick_slip.h"
#include "ds_table.h"

typedef struct {
    double damping;   /* P, N m s/rad */
    double stiffness; /* K, N m/rad */
    double inertia;   /* J_v, kg m^2 */
} ds_gains;

typedef struct {
    double wave;   /* filtered wave that comes up, rad/s */
    double torque; /* torque filtered for the slip, N m */
    double speed;  /* u, rad/s */
    double angle;  /* q, rad */
} ds_motion;

static inline ds_gains ds_soft_torque(const double value[], double ratio)
{
    const double damping = ratio * ds_impedance(value);
    const ds_gains gains = {damping, damping * ds_stick_slip_frequency(value) / 6.0, 0.0};
    return gains;
}

static inline ds_gains ds_absorber(const double value[])
{
    const double frequency = ds_stick_slip_frequency(value);
    const double damping = 1.5 * ds_impedance(value);
    const double inertia = damping / (4.0 * frequency);
    const ds_gains gains = {damping, inertia * (frequency * frequency), inertia};
    return gains;
}

/* the wave that comes up, of speed and torque or of their derivatives */
static inline double ds_wave(const double value[], const double impedance)
{
    return (value[DS_top_speed] - value[DS_top_torque] / impedance) * 0.5;
}

static inline int ds_is_compensated(const double value[])
{
    return (int)value[DS_slip] == 2;
}

/* the speed that the string's top is to turn with */
static inline double ds_turning(const double value[], double torque)
{
    return ds_is_compensated(value) ? value[DS_speed_ref] : value[DS_speed_ref] - torque / value[DS_c_a];
}

static inline ds_motion ds_virtual_drive_begin(const double value[], ds_gains gains)
{
    const double impedance = ds_impedance(value);
    const double torque = value[DS_top_torque];
    const double wave = ds_wave(value, impedance);
    const double pull = impedance * (ds_turning(value, torque) - 2.0 * wave);
    const double angle = gains.stiffness > 0.0 ? pull / gains.stiffness : 0.0;
    const double speed = gains.stiffness > 0.0 ? 0.0 : pull / (impedance + gains.damping);
    const ds_motion motion = {wave, torque, speed, angle};
    return motion;
}

static inline ds_motion ds_virtual_drive_advance(ds_motion before, ds_gains gains, const double value[],
                                                 const double slope[], const double end[], double elapsed)
{
    const double impedance = ds_impedance(value);
    const double filter_time = value[DS_filter_time];
    const double first = ds_wave(value, impedance);
    ds_motion after = {0.0, 0.0, 0.0, 0.0};
    after.wave = ds_low_pass(before.wave, first, ds_wave(slope, impedance), elapsed, filter_time);
    after.torque =
        ds_low_pass(before.torque, value[DS_top_torque], slope[DS_top_torque], elapsed, value[DS_slip_time]);
    const double early = filter_time > 0.0 ? before.wave : first;
    double pull = impedance * (ds_turning(value, before.torque) - 2.0 * early);
    pull = (pull + impedance * (ds_turning(end, after.torque) - 2.0 * after.wave)) * 0.5;
    const double stiffness = gains.stiffness;
    const double resistance = impedance + gains.damping;
    if (gains.inertia > 0.0) {
        const double half = 0.5 * elapsed * (resistance + 0.5 * elapsed * stiffness);
        const double net = elapsed * (pull - stiffness * before.angle);
        after.speed = (before.speed * (gains.inertia - half) + net) / (gains.inertia + half);
        after.angle = before.angle + 0.5 * elapsed * (before.speed + after.speed);
        return after;
    }
    const double give = elapsed / resistance;
    after.angle = (before.angle * (1.0 - 0.5 * give * stiffness) + give * pull) / (1.0 + 0.5 * give * stiffness);
    return after;
}

/* u: a state, or, without inertia, what follows from the others */
static inline double ds_virtual_drive_speed(ds_motion motion, ds_gains gains, const double value[], double wave)
{
    const double impedance = ds_impedance(value);
    if (gains.inertia > 0.0) {
        return motion.speed;
    }
    const double pull = impedance * (ds_turning(value, motion.torque) - 2.0 * wave) - gains.stiffness * motion.angle;
    return pull / (impedance + gains.damping);
}

static inline double ds_virtual_drive_command(ds_motion motion, ds_gains gains, const double value[])
{
    const double impedance = ds_impedance(value);
    const double wave = value[DS_filter_time] > 0.0 ? motion.wave : ds_wave(value, impedance);
    const double speed = ds_virtual_drive_speed(motion, gains, value, wave);
    const double down = ds_turning(value, motion.torque) - speed - wave;
    return ((value[DS_c_a] + impedance) * down + (value[DS_c_a] - impedance) * wave) / value[DS_c_a];
}

/* derivatives of the motion by time */
static inline ds_motion ds_virtual_drive_rate(ds_motion motion, ds_gains gains, const double value[])
{
    const double impedance = ds_impedance(value);
    const double filter_time = value[DS_filter_time];
    const double wave = ds_wave(value, impedance);
    const double felt = filter_time > 0.0 ? motion.wave : wave;
    ds_motion rate = {0.0, 0.0, 0.0, 0.0};
    rate.wave = filter_time > 0.0 ? (wave - motion.wave) / filter_time : 0.0;
    rate.torque = (value[DS_top_torque] - motion.torque) / value[DS_slip_time];
    rate.angle = ds_virtual_drive_speed(motion, gains, value, felt);
    if (gains.inertia > 0.0) {
        const double pull = impedance * (ds_turning(value, motion.torque) - 2.0 * felt);
        const double held = (impedance + gains.damping) * motion.speed + gains.stiffness * motion.angle;
        rate.speed = (pull - held) / gains.inertia;
    }
    return rate;
}

/* derivative of the command in the direction `rate` of the motion and `seed` of the inputs */
static inline double ds_virtual_drive_change(ds_motion rate, ds_gains gains, const double value[], const double seed[])
{
    const double impedance = ds_impedance(value);
    const double slip = value[DS_c_a];
    const double wave = value[DS_filter_time] > 0.0 ? rate.wave : ds_wave(seed, impedance);
    const double turning = ds_is_compensated(value) ? seed[DS_speed_ref] : seed[DS_speed_ref] - rate.torque / slip;
    double speed = rate.speed;
    if (gains.inertia <= 0.0) {
        speed = (impedance * (turning - 2.0 * wave) - gains.stiffness * rate.angle) / (impedance + gains.damping);
    }
    const double down = turning - speed - wave;
    return ((slip + impedance) * down + (slip - impedance) * wave) / slip;
}

#endif
