/* What a law has answered last, which derivatives of its outputs and messages about them are made from. */
#ifndef DS_ANSWERED_H
#define DS_ANSWERED_H

#include "ds_table.h"

typedef struct {
    double value[DS_VARIABLES]; /* inputs at that instant, parameters, and the outputs */
    double slope[DS_VARIABLES]; /* derivatives of the inputs */
    double side;                /* 1 at the start, where the inputs begin to change so; -1 at the end of a step */
} ds_answered;

/* take the inputs as they are `elapsed` seconds after they were set; the outputs are still to be written */
static inline void ds_answered_take(ds_answered *last, const double value[], const double slope[], double elapsed)
{
    for (int i = 0; i < DS_VARIABLES; ++i) {
        last->value[i] = slope[i] == 0.0 ? value[i] : value[i] + slope[i] * elapsed; /* -0 stays -0 */
        last->slope[i] = slope[i];
    }
    last->side = elapsed > 0.0 ? -1.0 : 1.0;
}

/* hand the outputs out, and leave inputs as they were set */
static inline void ds_answered_give(const ds_answered *last, double value[])
{
    for (int i = 0; i < DS_VARIABLES; ++i) {
        value[i] = ds_variables[i].role == DS_OUTPUT ? last->value[i] : value[i];
    }
}

#endif
