/* A law without memory: its outputs at an instant follow from its inputs and parameters at that instant. The one file
 * of such a model includes this header, and defines the functions declared here and ds_model_check. */
#ifndef DS_MEMORYLESS_H
#define DS_MEMORYLESS_H

#include <string.h>

#include "ds_model.h"
#include "ds_table.h"

/* what the law has answered last; kept to be compared with */
typedef struct {
    double value[DS_VARIABLES];
} ds_answered;

/* write the outputs that go with the inputs and parameters */
static void answer(double value[]);

/* say what has changed since `before` that the user should know */
static void tell_changes(const double before[], const double value[], double time, ds_journal *journal);

size_t ds_model_size(const double value[], const ds_text text[], ds_journal *journal)
{
    (void)value;
    (void)text;
    (void)journal;
    return sizeof(ds_answered);
}

static void respond(ds_answered *last, double value[], double time, ds_journal *journal)
{
    answer(value);
    if (journal->event != NULL) {
        tell_changes(last->value, value, time, journal);
    }
    memcpy(last->value, value, sizeof last->value);
}

ds_result ds_model_start(void *memory, size_t size, double value[], const ds_text text[], double time,
                         ds_journal *journal)
{
    (void)size;
    (void)text;
    respond(memory, value, time, journal);
    return DS_OK;
}

ds_result ds_model_step(void *memory, double value[], const double slope[], double time, double end,
                        ds_journal *journal)
{
    (void)slope;
    (void)time;
    respond(memory, value, end, journal);
    return DS_OK;
}

#endif
