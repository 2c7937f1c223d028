/* The work a second of the string takes, and the bound beyond which it is refused. Follows models/plant/work.py, which
 * explains it. */
#ifndef DS_WORK_H
#define DS_WORK_H

#include "ds_linkage.h"

#define DS_MOST_ASKED 40.0     /* 1, greatest multiple of the work of the start values that parameters may ask for */
#define DS_MOST_TIMES 50.0     /* 1, and with what the motion takes beside */
#define DS_SAVED 0.25          /* s, whose earnings a bit can save, and has at the start */
#define DS_INPUT_CREDIT 100.0  /* 1, what a change of an input earns: a jump comes back until it has faded */

/* what the work follows from */
typedef struct {
    double travel_time; /* s */
    double damping;     /* N m s/rad, Z + c_b */
    double inertia;     /* kg m2, I_B */
    double blocks;      /* 1, blocks in a travel time */
    double asked;       /* 1, of these, the blocks that its cells ask for; more are asked for by its damping */
    double beta;        /* N s/rad, damping along the string */
} ds_work;

/* times the work of the start values */
DS_SHARED double ds_work_times(const ds_work *work);
/* work a second that following a bit may take, in blocks: what blocks that cross leave [1/s] */
DS_SHARED double ds_work_earning(double beta, double travel_time, int blocks);
/* what to set so that there is less */
DS_SHARED const char *ds_work_remedy(const ds_work *work);

#endif
