/* A law without memory: its outputs at an instant follow from its inputs and parameters at that instant. The one file
 * of such a model includes this header, and defines `answer` and ds_model_check. */
#ifndef DS_MEMORYLESS_H
#define DS_MEMORYLESS_H

#include "ds_model.h"
#include "ds_table.h"

/* write the outputs that go with the inputs and parameters */
static void answer(double value[]);

size_t ds_model_size(const double value[], const ds_text text[], ds_journal *journal)
{
    (void)value;
    (void)text;
    (void)journal;
    return 1;
}

ds_result ds_model_start(void *memory, size_t size, double value[], const ds_text text[], double time,
                         ds_journal *journal)
{
    (void)memory;
    (void)size;
    (void)text;
    (void)time;
    (void)journal;
    answer(value);
    return DS_OK;
}

ds_result ds_model_step(void *memory, double value[], const double slope[], double time, double end,
                        ds_journal *journal)
{
    (void)memory;
    (void)slope;
    (void)time;
    (void)end;
    (void)journal;
    answer(value);
    return DS_OK;
}

#endif
