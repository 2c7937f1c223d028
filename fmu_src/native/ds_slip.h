/* The bit equation integrated over one piece of slip. Follows models/plant/slip.py, which explains it. */
#ifndef DS_SLIP_H
#define DS_SLIP_H

#include "ds_clock.h"
#include "ds_friction.h"
#include "ds_linkage.h"
#include "ds_quartic.h"

#define DS_GREATEST_STIFFNESS 0.5 /* a piece is too rough if its slope depends on the speed more strongly */

/* constants of the bit equation */
typedef struct {
    double twice_impedance; /* N m s/rad, 2 Z */
    double damping;         /* N m s/rad, Z + c_b */
    double viscosity;       /* N m s/rad, c_b, eq. (3) */
    double inertia;         /* kg m2, I_B, eq. (2) */
    ds_friction friction;   /* at the lever R_b */
} ds_bit_law;

/* what is asked of a piece */
typedef struct {
    double truncation; /* rad/s, truncation from which on a piece is too rough */
    double newton;     /* rad/s, correction after which Newton's method ends */
} ds_accuracy;

/* the weight on bit over a piece */
typedef struct {
    double weight; /* N, at its begin */
    double rise;   /* N, its rise over the piece */
} ds_wob;

typedef struct {
    ds_quartic speed; /* rad/s, bit speed over the piece */
    double power;     /* W, integral of torque times speed over the piece, per unit of x */
    double roughness; /* 1, how hard the speed is to follow; a piece above 1 is to be halved */
    double work;      /* 1, what it took, in blocks */
} ds_slip;

DS_SHARED ds_accuracy ds_accuracy_on(const ds_clock *clock);
/* the slip in a direction over a piece of a duration [s] that begins with the speed `start` [rad/s]; a piece whose
 * begin shows that it is too rough is integrated only if it is the last try */
DS_SHARED ds_slip ds_slip_collocate(const ds_bit_law *law, const ds_accuracy *accuracy, int direction, double duration,
                                    double start, ds_quartic incident, ds_wob wob, int last_try);

#endif
