/* The torque on bit, eqs. (3) and (4): viscous damping and set-valued dry friction. Follows models/plant/friction.py.
 * Another friction law is written here, and ds_friction_table.h names its parameters in the tables: nowhere else in C. */
#ifndef DS_FRICTION_H
#define DS_FRICTION_H

#include <math.h>

#include "ds_exp.h"

#define DS_GREATEST_EXPONENT 4.0 /* greatest exponent of the friction where it is continued beyond rest */

typedef struct {
    double R_b;     /* m, bit radius, eq. (3) */
    double v_f;     /* rad/s, eq. (4) */
    double c_b;     /* N m s/rad, damping at the bit, eq. (3) */
    double mu_cb;   /* 1, Coulomb friction, eq. (4) */
    double mu_sb;   /* 1, static friction, eq. (4) */
    double gamma_b; /* 1, velocity decrease rate, eq. (4) */
} ds_friction_parameters;

/* dry friction of eq. (4) at a lever: mu_b(v) times a lever [m] that is 1 or R_b */
typedef struct {
    double coulomb; /* m, lever times mu_cb */
    double excess;  /* m, lever times mu_sb - mu_cb */
    double static_; /* m, lever times mu_sb */
    double rate;    /* s/rad, gamma_b / v_f, by which the slope itself changes with the speed, relative to its value */
} ds_friction;

/* the friction in a slip */
typedef struct {
    double arm;    /* m, without the load */
    double torque; /* N m, with it; it acts against the slip */
    double slope;  /* N m s/rad, derivative of the torque by the speed */
} ds_friction_point;

static inline ds_friction ds_friction_of(const ds_friction_parameters *parameters, double lever)
{
    const ds_friction_parameters *const p = parameters;
    const ds_friction friction = {
        lever * p->mu_cb,
        lever * (p->mu_sb - p->mu_cb),
        lever * p->mu_sb,
        p->gamma_b / p->v_f,
    };
    return friction;
}

/* the exponential of eq. (4), continued smoothly through rest; beyond rest it only serves the search for the stop, and
 * there it is capped */
static inline double ds_friction_fading(double exponent)
{
    return ds_exp(exponent < DS_GREATEST_EXPONENT ? exponent : DS_GREATEST_EXPONENT);
}

/* the friction under a load, which is what the lever does not contain, at a speed in the direction of the slip */
static inline ds_friction_point ds_friction_at(const ds_friction *friction, double load, double speed)
{
    const double falling = friction->excess * ds_friction_fading(-friction->rate * speed);
    const double arm = friction->coulomb + falling;
    const ds_friction_point point = {arm, load * arm, -(load * falling * friction->rate)};
    return point;
}

/* whether a run may go on with other parameters without a change of the friction */
static inline int ds_friction_same(const ds_friction_parameters *a, const ds_friction_parameters *b)
{
    return a->c_b == b->c_b && a->mu_cb == b->mu_cb && a->mu_sb == b->mu_sb && a->gamma_b == b->gamma_b;
}

/* what moves the torque on bit in a slip, besides its parameters */
typedef struct {
    double weight; /* N */
    double speed;  /* rad/s */
} ds_friction_motion;

/* how much T of eq. (3) changes with weight, speed and parameters in a slip in `direction`, along a seed */
static inline double ds_friction_torque_change(const ds_friction_parameters *parameters, ds_friction_motion motion,
                                               int direction, const ds_friction_parameters *seed,
                                               ds_friction_motion motion_seed)
{
    const ds_friction_parameters *const p = parameters;
    const double speed = motion.speed;
    const double excess = p->mu_sb - p->mu_cb;
    const double exponent = p->gamma_b * fabs(speed) / p->v_f;
    const double fading = ds_exp(-exponent);
    const double exponent_change = (seed->gamma_b * fabs(speed) + p->gamma_b * direction * motion_seed.speed -
                                    exponent * seed->v_f) / p->v_f;
    const double mu = p->mu_cb + excess * fading;
    const double mu_change = seed->mu_cb + (seed->mu_sb - seed->mu_cb - excess * exponent_change) * fading;
    const double dry_change =
        motion_seed.weight * p->R_b * mu + motion.weight * seed->R_b * mu + motion.weight * p->R_b * mu_change;
    return seed->c_b * speed + p->c_b * motion_seed.speed + direction * dry_change;
}

#endif
