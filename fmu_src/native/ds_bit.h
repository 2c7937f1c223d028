/* The bit: the down-going wave is incident, dry friction holds or drags, the up-going wave is outgoing.
 * Follows models/plant/bit.py. */
#ifndef DS_BIT_H
#define DS_BIT_H

#include "ds_clock.h"
#include "ds_friction.h"
#include "ds_line.h"
#include "ds_linkage.h"
#include "ds_slip.h"

typedef struct {
    int64_t block;        /* 1, block of the piece that holds the present */
    double begin;         /* 1, its begin as a fraction of the block */
    double end;           /* 1, its end */
    int direction;        /* 1, 1 or -1 while the bit slips that way, 0 while it is stuck */
    int stops;            /* 1, the piece ends because the bit comes to rest there */
    int releases;         /* 1, direction in which the bit breaks loose at the end of the piece, 0 if it does not */
    int halted;           /* 1, the last piece ended at rest, not yet decided whether the bit sticks */
    int slips;            /* 1, releases since the start */
    ds_quartic incident;  /* rad/s, D(t - Gamma) on the piece */
    ds_quartic turning;   /* rad/s, v(t) on the piece */
    ds_piece incoming;    /* rad/s, the piece of the down-going wave that `incident` is a part of */
    ds_accuracy accuracy; /* what is asked of a piece; constant */
    double truncation;    /* rad/s, what is asked of the piece; more when breaks are folded that matter */
    double roughness;     /* 1, how hard the speed over the piece is to follow; a piece above 1 is halved */
    int whole;            /* 1, the piece is as long as it was integrated: `power` holds for it */
    double power;         /* W, integral of torque times speed over the piece as it was integrated, per unit of x */
    double speed;         /* rad/s, bit speed at `begin` */
    ds_ramp wob;          /* N, the weight on bit as it was set */
    double weight;        /* N, weight on bit at `begin` */
    double weight_rise;   /* N, its rise over the piece */
    double angle;         /* rad, angle turned up to `begin` */
    double loss;          /* J, energy lost up to `begin` */
    double stuck;         /* s, time stuck up to `begin` */
    double last_stop;     /* s */
    double last_release;  /* s */
    double earning;       /* 1/s, work that following it may take in a second, in blocks; constant */
    double credit;        /* 1, work that it may still take; negative once it is spent */
} ds_bit;

DS_SHARED void ds_bit_start(ds_bit *bit, const ds_clock *clock, double speed);
/* let the bit earn so much a second, and begin with what it can save of it */
DS_SHARED void ds_bit_endow(ds_bit *bit, double earning);
/* add to the credit, as far as it can be saved */
DS_SHARED void ds_bit_earn(ds_bit *bit, double work);
DS_SHARED void ds_bit_open(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit, ds_line *down,
                           const ds_piece *down_ring);
DS_SHARED void ds_bit_close(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit, ds_line *up, ds_piece *up_ring);
/* go to the end of the piece */
DS_SHARED void ds_bit_finish(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit);
/* end the piece at a fraction inside it, 0 if it begins there anyway; the caller then closes it, and opens a new one */
DS_SHARED int ds_bit_cut(ds_bit *bit, double fraction);
DS_SHARED double ds_bit_torque(const ds_bit_law *law, const ds_bit *bit, double x);
DS_SHARED double ds_bit_power_integral(const ds_bit_law *law, const ds_bit *bit, double x);
DS_SHARED void ds_bit_extremes(const ds_bit *bit, double x0, double x1, double *least, double *greatest);

#endif
