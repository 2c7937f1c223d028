/* The bit: the down-going wave arrives, dry friction holds or drags, the up-going wave leaves. Follows models/bit.py. */
#ifndef DS_BIT_H
#define DS_BIT_H

#include "ds_clock.h"
#include "ds_line.h"
#include "ds_linkage.h"

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

typedef struct {
    int64_t cell;        /* 1, cell of the piece that holds the present */
    double begin;        /* 1, its begin as a fraction of the cell */
    double end;          /* 1, its end */
    int direction;       /* 1, 1 or -1 while the bit slips that way, 0 while it is stuck */
    int stops;           /* 1, the piece ends because the bit comes to rest there */
    int releases;        /* 1, direction in which the bit breaks loose at the end of the piece, 0 if it does not */
    int arrived;         /* 1, the last piece ended at rest, not yet decided whether the bit sticks */
    int slips;           /* 1, releases since the start */
    ds_quartic arriving;   /* rad/s, D(t - Gamma) on the piece */
    ds_quartic turning;    /* rad/s, v(t) on the piece */
    ds_piece incoming;   /* rad/s, the piece of the down-going wave that `arriving` is a part of */
    double greatest_stiffness; /* 1, stiffness above which a piece is halved */
    double greatest_fading;    /* rad/s, fading of the friction above which a piece is halved */
    double speed;        /* rad/s, bit speed at `begin` */
    ds_ramp pressure;    /* N, the weight on bit as it was set */
    double weight;       /* N, weight on bit at `begin` */
    double weight_rise;  /* N, its rise over the piece */
    double angle;        /* rad, angle turned up to `begin` */
    double loss;         /* J, energy lost up to `begin` */
    double stuck;        /* s, time stuck up to `begin` */
    double last_stop;    /* s */
    double last_release; /* s */
} ds_bit;

DS_SHARED void ds_bit_start(ds_bit *bit, const ds_clock *clock, double speed);
DS_SHARED void ds_bit_open(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit, ds_line *down,
                           const ds_piece *down_ring);
DS_SHARED void ds_bit_close(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit, ds_line *up, ds_piece *up_ring);
/* end the piece at a fraction of the cell inside it; the caller then opens a new one */
DS_SHARED void ds_bit_cut(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit, double fraction, ds_line *up,
                          ds_piece *up_ring);
DS_SHARED double ds_bit_torque(const ds_bit_law *law, const ds_bit *bit, double x);
DS_SHARED double ds_bit_power_integral(const ds_bit_law *law, const ds_bit *bit, double x);
DS_SHARED void ds_bit_extremes(const ds_bit *bit, double x0, double x1, double *least, double *greatest);

#endif
