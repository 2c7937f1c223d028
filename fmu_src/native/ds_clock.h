/* Places on the time axis as a block number and a fraction of the block. Follows models/plant/clock.py. */
#ifndef DS_CLOCK_H
#define DS_CLOCK_H

#include <stdint.h>

#define DS_CELL_LIMIT 0.0005 /* s, longest cell of the default grid */
#define DS_BLOCK 8           /* 1, cells in a block, at most */
#define DS_LEAST_BLOCKS 4    /* 1, blocks in a travel time, at least */
#define DS_SNAP 1e-11 /* blocks, nearer than this to a boundary an input change is taken to be at the boundary */

typedef struct {
    double start; /* s, begin of block 0 */
    double block; /* s, duration of a block */
} ds_clock;

typedef struct {
    int64_t block;   /* 1, block number */
    double fraction; /* 1, in (0, 1]; 0 only at the start */
} ds_place;

static inline ds_place ds_clock_place(const ds_clock *clock, double time)
{
    const double position = (time - clock->start) / clock->block;
    ds_place place;
    place.block = (int64_t)position;
    place.fraction = position - (double)place.block;
    if (place.fraction == 0.0 && place.block > 0) {
        place.block -= 1;
        place.fraction = 1.0;
    }
    return place;
}

/* blocks in a travel time of so many cells */
static inline int ds_clock_blocks(int cells)
{
    const int blocks = (cells + DS_BLOCK - 1) / DS_BLOCK;
    return blocks > DS_LEAST_BLOCKS ? blocks : DS_LEAST_BLOCKS;
}

/* how many times the longest block of the default grid a block is: the longer, the more error is allowed */
static inline double ds_clock_coarseness(const ds_clock *clock)
{
    return clock->block / (DS_BLOCK * DS_CELL_LIMIT);
}

static inline double ds_clock_time(const ds_clock *clock, int64_t block, double fraction)
{
    return clock->start + ((double)block + fraction) * clock->block;
}

/* an input that is `value` at a place and changes by `slope` per second from there */
typedef struct {
    ds_place since;
    double value;
    double slope;
} ds_ramp;

/* the input at the begin of a piece, and its rise over the piece */
static inline double ds_ramp_at(const ds_ramp *ramp, const ds_clock *clock, int64_t block, double begin, double end,
                                double *rise)
{
    if (ramp->slope == 0.0) {
        *rise = 0.0;
        return ramp->value;
    }
    const double slope = ramp->slope * clock->block;
    const double elapsed = (double)(block - ramp->since.block) + (begin - ramp->since.fraction);
    *rise = (end - begin) * slope;
    return ramp->value + elapsed * slope;
}

#endif
