/* Places on the time axis as a cell number and a fraction of the cell. Follows models/clock.py. */
#ifndef DS_CLOCK_H
#define DS_CLOCK_H

#include <stdint.h>

#define DS_CELL_LIMIT 0.0005 /* s, longest cell of the default grid */
#define DS_SNAP 1e-11 /* cells, nearer than this to a boundary an input change is taken to be at the boundary */

typedef struct {
    double start; /* s, begin of cell 0 */
    double cell;  /* s, duration of a cell */
} ds_clock;

typedef struct {
    int64_t cell;    /* 1, cell number */
    double fraction; /* 1, in (0, 1]; 0 only at the start */
} ds_place;

static inline ds_place ds_clock_place(const ds_clock *clock, double time)
{
    const double position = (time - clock->start) / clock->cell;
    ds_place place;
    place.cell = (int64_t)position;
    place.fraction = position - (double)place.cell;
    if (place.fraction == 0.0 && place.cell > 0) {
        place.cell -= 1;
        place.fraction = 1.0;
    }
    return place;
}

/* how many times the longest cell of the default grid a cell is, at least 1; more error is allowed then */
static inline double ds_clock_coarseness(const ds_clock *clock)
{
    const double ratio = clock->cell / DS_CELL_LIMIT;
    return ratio > 1.0 ? ratio : 1.0;
}

static inline double ds_clock_time(const ds_clock *clock, int64_t cell, double fraction)
{
    return clock->start + ((double)cell + fraction) * clock->cell;
}

/* an input that is `value` at a place and changes by `slope` per second from there */
typedef struct {
    ds_place since;
    double value;
    double slope;
} ds_ramp;

/* the input at the begin of a piece, and its rise over the piece */
static inline double ds_ramp_at(const ds_ramp *ramp, const ds_clock *clock, int64_t cell, double begin, double end,
                                double *rise)
{
    if (ramp->slope == 0.0) {
        *rise = 0.0;
        return ramp->value;
    }
    const double slope = ramp->slope * clock->cell;
    const double elapsed = (double)(cell - ramp->since.cell) + (begin - ramp->since.fraction);
    *rise = (end - begin) * slope;
    return ramp->value + elapsed * slope;
}

#endif
