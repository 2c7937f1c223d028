/* A law with a memory: filters, integrators, what it has seen. The memory is an array of numbers: the one file of such a
 * model names its places before it includes this header, `enum { FIRST, SECOND, DS_MEMORY };`, and then defines the
 * functions declared here and ds_model_check. Follows fmu_src/python/law.py. */
#ifndef DS_LAW_H
#define DS_LAW_H

#include <stdio.h>
#include <string.h>

#include "ds_answered.h"
#include "ds_model.h"
#include "ds_number.h"

/* fill the memory from inputs and parameters at the start */
static void begin(double memory[], const double value[]);

/* write how much that changes in the direction `seed` of inputs and parameters */
static void begin_change(const double value[], const double seed[], double drift[]);

/* go on for `elapsed` seconds, in which the inputs go from value[i] along slope[i]. DS_DISCARD with a reason if that
 * cannot be; what has been written to the memory does not count then */
static ds_result advance(double memory[], const double value[], const double slope[], double elapsed,
                         ds_journal *journal);

/* write the derivatives of the memory by time at an instant */
static void move(const double memory[], const double value[], double drift[]);

/* write the outputs that go with memory, inputs and parameters */
static void answer(const double memory[], double value[]);

/* write the derivatives of the Real outputs in the direction `drift` of the memory and `seed` of inputs and parameters;
 * at a kink, to that side */
static void differentiate(const double memory[], const double value[], const double drift[], const double seed[],
                          double change[]);

/* say what has changed in the outputs since `before` that the user should know */
static void tell_changes(const double before[], const double value[], double time, ds_journal *journal);

/* refuse a step so long that what is added up in it leaves the range of numbers */
static inline ds_result ds_require_short(double elapsed, ds_journal *journal)
{
    if (elapsed <= 1e6) {
        return DS_OK;
    }
    snprintf(journal->reason, sizeof journal->reason, "a step of %s s cannot be followed; expected at most 1e+06 s",
             ds_number(elapsed).text);
    return DS_DISCARD;
}

typedef struct {
    double memory[DS_MEMORY];
    ds_answered last;
} ds_law;

size_t ds_model_size(const double value[], const ds_text text[], ds_journal *journal)
{
    (void)value;
    (void)text;
    (void)journal;
    return sizeof(ds_law);
}

static void respond(ds_law *law, double value[], const double slope[], double elapsed, double time, ds_journal *journal)
{
    const ds_answered before = law->last;
    ds_answered_take(&law->last, value, slope, elapsed);
    answer(law->memory, law->last.value);
    ds_answered_give(&law->last, value);
    if (journal->event != NULL) {
        tell_changes(before.value, law->last.value, time, journal);
    }
}

ds_result ds_model_start(void *memory, size_t size, double value[], const double slope[], const ds_text text[],
                         double time, ds_journal *journal)
{
    ds_law *const law = memory;
    (void)size;
    (void)text;
    begin(law->memory, value);
    respond(law, value, slope, 0.0, time, journal);
    return DS_OK;
}

ds_result ds_model_step(void *memory, double value[], const double slope[], double time, double end,
                        ds_journal *journal)
{
    ds_law *const law = memory;
    double next[DS_MEMORY];
    memcpy(next, law->memory, sizeof next);
    const ds_result result = advance(next, value, slope, end - time, journal);
    if (result == DS_OK) {
        memcpy(law->memory, next, sizeof next);
        respond(law, value, slope, end - time, end, journal);
    }
    return result;
}

void ds_model_output_derivatives(const void *memory, double rate[])
{
    const ds_law *const law = memory;
    const double side = law->last.side;
    double seed[DS_VARIABLES];
    double drift[DS_MEMORY] = {0.0};
    move(law->memory, law->last.value, drift);
    for (int i = 0; i < DS_MEMORY; ++i) {
        drift[i] = side * drift[i];
    }
    for (int i = 0; i < DS_VARIABLES; ++i) {
        seed[i] = side * law->last.slope[i];
    }
    differentiate(law->memory, law->last.value, drift, seed, rate);
    for (int i = 0; i < DS_VARIABLES; ++i) {
        rate[i] = side * rate[i];
    }
}

void ds_model_directional_derivatives(const void *memory, const double value[], const double seed[], int at_start,
                                      double change[])
{
    const ds_law *const law = memory;
    double drift[DS_MEMORY] = {0.0};
    (void)value;
    if (at_start) {
        begin_change(law->last.value, seed, drift);
    }
    differentiate(law->memory, law->last.value, drift, seed, change);
}

#endif
