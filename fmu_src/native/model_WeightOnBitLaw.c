/* The weight on bit of eq. (22). Follows models/laws.py. */
#include <math.h>
#include <stdio.h>

#include "ds_model.h"
#include "ds_number.h"
#include "ds_table.h"

size_t ds_model_size(const double value[], const ds_text text[], ds_journal *journal)
{
    (void)value;
    (void)text;
    (void)journal;
    return 1; /* the law has no memory */
}

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    if (value[DS_WOB_max] < value[DS_WOB_0]) {
        const ds_number_text found = ds_number(value[DS_WOB_max]);
        const ds_number_text least = ds_number(value[DS_WOB_0]);
        snprintf(journal->reason, sizeof journal->reason, "WOB_max is %s; expected at least WOB_0 = %s", found.text,
                 least.text);
        return DS_DISCARD;
    }
    return DS_OK;
}

static void answer(double value[])
{
    const double weight = value[DS_K_w] * fabs(value[DS_bit_speed]) + value[DS_WOB_0];
    value[DS_WOB] = weight <= value[DS_WOB_max] ? weight : value[DS_WOB_max];
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
