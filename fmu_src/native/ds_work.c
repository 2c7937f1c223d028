#include "ds_work.h"

#include "ds_slip.h"

#define START_BLOCKS 250.0   /* 1/s, blocks a second of the start values */
#define SHORTENED 2.0        /* 1, work of the pieces in the time in which the bit answers, in blocks */
#define CROSSING 0.12        /* 1, work of two blocks that cross, in blocks that the ends take */
#define START_DAMPED 6000.0  /* 1/s, work a second of the start values with the crossings of a little damping */

static double brought(const ds_work *work)
{
    return work->blocks / work->travel_time;
}

static double answered(const ds_work *work)
{
    return work->damping / (work->inertia * DS_GREATEST_STIFFNESS);
}

double ds_work_times(const ds_work *work)
{
    const double ends = answered(work) > brought(work) ? SHORTENED * answered(work) : brought(work);
    if (work->beta > 0.0) {
        return (ends + CROSSING * (2.0 * work->blocks * brought(work))) / START_DAMPED;
    }
    return ends / START_BLOCKS;
}

double ds_work_earning(double beta, double travel_time, int blocks)
{
    const double least = DS_MOST_TIMES * START_BLOCKS;
    if (!(beta > 0.0)) {
        return least;
    }
    const double left = DS_MOST_TIMES * START_DAMPED - CROSSING * (2.0 * blocks * (blocks / travel_time));
    return left > least ? left : least;
}

const char *ds_work_remedy(const ds_work *work)
{
    if (answered(work) > brought(work)) {
        return "a greater I_B or a lower c_b";
    }
    if (work->beta > 0.0 && work->blocks > work->asked) {
        return "a lower beta or a shorter L";
    }
    return work->beta > 0.0 ? "fewer cells or a shorter L" : "fewer cells or a longer L";
}
