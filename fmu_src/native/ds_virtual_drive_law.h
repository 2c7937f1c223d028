/* A law that makes the drive a virtual one. The one file of such a model includes this header and defines the function
 * declared here and ds_model_check. Follows fmu_src/python/virtual_drive_law.py. */
#ifndef DS_VIRTUAL_DRIVE_LAW_H
#define DS_VIRTUAL_DRIVE_LAW_H

enum { DS_REST, DS_ENGAGED, WAVE, TORQUE, SPEED, ANGLE, DAMPING, STIFFNESS, INERTIA, DS_MEMORY };

#include "ds_switched_law.h"
#include "ds_virtual_drive.h"

/* what the string is to meet, from the parameters */
static ds_gains gains_of(const double value[]);

static ds_motion motion_in(const double memory[])
{
    const ds_motion motion = {memory[WAVE], memory[TORQUE], memory[SPEED], memory[ANGLE]};
    return motion;
}

static void keep_motion(double memory[], ds_motion motion)
{
    memory[WAVE] = motion.wave;
    memory[TORQUE] = motion.torque;
    memory[SPEED] = motion.speed;
    memory[ANGLE] = motion.angle;
}

static ds_gains gains_in(const double memory[])
{
    const ds_gains gains = {memory[DAMPING], memory[STIFFNESS], memory[INERTIA]};
    return gains;
}

static void remember(double memory[], const double value[])
{
    const ds_gains gains = gains_of(value);
    keep_motion(memory, ds_virtual_drive_begin(value, gains));
    memory[DAMPING] = gains.damping;
    memory[STIFFNESS] = gains.stiffness;
    memory[INERTIA] = gains.inertia;
}

static void go_on(double memory[], const double value[], const double slope[], const double end[], double elapsed)
{
    const ds_gains gains = gains_in(memory);
    keep_motion(memory, ds_virtual_drive_advance(motion_in(memory), gains, value, slope, end, elapsed));
}

static void flow(const double memory[], const double value[], double drift[])
{
    keep_motion(drift, ds_virtual_drive_rate(motion_in(memory), gains_in(memory), value));
}

static double ask(const double memory[], const double value[])
{
    return ds_virtual_drive_command(motion_in(memory), gains_in(memory), value);
}

static double ask_change(const double memory[], const double value[], const double drift[], const double seed[])
{
    return ds_virtual_drive_change(motion_in(drift), gains_in(memory), value, seed);
}

#endif
