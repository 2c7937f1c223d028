/* The torque on bit, eqs. (3) and (4): viscous damping and set-valued dry friction. Follows models/plant/friction.py. */
#ifndef DS_FRICTION_H
#define DS_FRICTION_H

#include "ds_exp.h"

#define DS_GREATEST_EXPONENT 4.0 /* where the friction is continued beyond rest, its exponent is kept below this */

typedef struct {
    double twice_impedance; /* N m s/rad, 2 Z */
    double damping;         /* N m s/rad, Z + c_b */
    double viscosity;       /* N m s/rad, c_b, eq. (3) */
    double inertia;         /* kg m2, I_B, eq. (2) */
    double coulomb;         /* m, R_b mu_cb, eqs. (3) and (4) */
    double excess;          /* m, R_b (mu_sb - mu_cb) */
    double static_;         /* m, R_b mu_sb */
    double rate;            /* s/rad, gamma_b / v_f */
} ds_bit_law;

/* the exponential of eq. (4) in a slip in `direction`, continued smoothly through rest.
 * Beyond rest it only serves the search for the stop; there it is capped. */
static inline double ds_friction_fading(const ds_bit_law *law, int direction, double speed)
{
    const double exponent = -law->rate * (direction * speed);
    return ds_exp(exponent < DS_GREATEST_EXPONENT ? exponent : DS_GREATEST_EXPONENT);
}

#endif
