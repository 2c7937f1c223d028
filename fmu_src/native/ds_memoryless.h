/* A law without memory: its outputs at an instant follow from its inputs and parameters at that instant. The one file
 * of such a model includes this header, and defines the functions declared here and ds_model_check. */
#ifndef DS_MEMORYLESS_H
#define DS_MEMORYLESS_H

#include "ds_answered.h"
#include "ds_model.h"

/* write the outputs that go with the inputs and parameters */
static void answer(double value[]);

/* write the derivatives of the Real outputs in the direction `seed` of inputs and parameters; at a kink, from that side */
static void differentiate(const double value[], const double seed[], double change[]);

/* say what has changed since `before` that the user should know */
static void tell_changes(const double before[], const double value[], double time, ds_journal *journal);

size_t ds_model_size(const double value[], const ds_text text[], ds_journal *journal)
{
    (void)value;
    (void)text;
    (void)journal;
    return sizeof(ds_answered);
}

/* answer the inputs as they are `elapsed` seconds after they were set, at a time */
static void respond(ds_answered *last, double value[], const double slope[], double elapsed, double time,
                    ds_journal *journal)
{
    const ds_answered before = *last;
    ds_answered_take(last, value, slope, elapsed);
    answer(last->value);
    ds_answered_give(last, value);
    if (journal->event != NULL) {
        tell_changes(before.value, last->value, time, journal);
    }
}

ds_result ds_model_start(void *memory, size_t size, double value[], const double slope[], const ds_text text[],
                         double time, ds_journal *journal)
{
    (void)size;
    (void)text;
    respond(memory, value, slope, 0.0, time, journal);
    return DS_OK;
}

ds_result ds_model_step(void *memory, double value[], const double slope[], double time, double end,
                        ds_journal *journal)
{
    respond(memory, value, slope, end - time, end, journal);
    return DS_OK;
}

void ds_model_output_derivatives(const void *memory, double rate[])
{
    const ds_answered *const last = memory;
    double seed[DS_VARIABLES];
    for (int i = 0; i < DS_VARIABLES; ++i) {
        seed[i] = last->side * last->slope[i];
    }
    differentiate(last->value, seed, rate);
    for (int i = 0; i < DS_VARIABLES; ++i) {
        rate[i] = last->side * rate[i];
    }
}

void ds_model_directional_derivatives(const void *memory, const double value[], const double seed[], int at_start,
                                      double change[])
{
    const ds_answered *const last = memory;
    (void)value;
    (void)at_start;
    differentiate(last->value, seed, change);
}

#endif
