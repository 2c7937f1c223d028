/* The top end: the up-going wave is incident, the drive turns, the down-going wave is outgoing. Follows models/plant/top.py. */
#ifndef DS_TOP_H
#define DS_TOP_H

#include "ds_clock.h"
#include "ds_line.h"
#include "ds_linkage.h"

typedef struct {
    double reflection;   /* 1, Upsilon */
    double transmission; /* 1, c_a / Lambda */
    double sliding;      /* N m s/rad, c_a, eq. (2) */
} ds_top_law;

typedef struct {
    int64_t block;       /* 1, block of the piece that holds the present */
    double begin;        /* 1, its begin as a fraction of the block */
    double end;          /* 1, its end */
    ds_quartic incident; /* rad/s, U_b(t - Gamma) on the piece */
    ds_quartic outgoing; /* rad/s, D(t) on the piece */
    ds_piece incoming;   /* rad/s, the piece of the up-going wave that `incident` is a part of */
    ds_ramp omega;       /* rad/s, the drive */
    double angle;        /* rad, angle of the top up to `begin` */
    double work;         /* J, work on the string up to `begin` */
    double driven;       /* J, work of the drive up to `begin` */
    double slid;         /* J, lost between them in the sliding up to `begin` */
} ds_top;

/* integrals from 0 to x of a piece, per unit of x */
typedef struct {
    double work;   /* W, of top_torque times top_speed */
    double driven; /* W, of top_torque times Omega */
    double slid;   /* W, of top_torque times the difference */
} ds_top_powers;

DS_SHARED void ds_top_start(ds_top *top, double angle);
DS_SHARED void ds_top_open(const ds_top_law *law, const ds_clock *clock, ds_top *top, ds_line *up,
                           const ds_piece *up_ring);
DS_SHARED void ds_top_close(const ds_top_law *law, const ds_clock *clock, ds_top *top, ds_line *down,
                            ds_piece *down_ring);
/* go to the end of the piece */
DS_SHARED void ds_top_finish(const ds_top_law *law, const ds_clock *clock, ds_top *top);
/* end the piece at a fraction inside it, 0 if it begins there anyway; the caller then closes it, and opens a new one */
DS_SHARED int ds_top_cut(ds_top *top, double fraction);
DS_SHARED ds_quartic ds_top_speed(const ds_top *top);
/* Omega at x of the piece [rad/s] */
DS_SHARED double ds_top_drive(const ds_clock *clock, const ds_top *top, double x);
DS_SHARED double ds_top_torque(const ds_top_law *law, const ds_clock *clock, const ds_top *top, double x);
DS_SHARED ds_top_powers ds_top_power_integrals(const ds_top_law *law, const ds_clock *clock, const ds_top *top,
                                               double x);

#endif
