/* What a model is to the FMI adapter. The model.c of every FMU fills in these functions.
 *
 * `value` holds one number per variable by value reference (DS_<name> of ds_table.h); Booleans are 0 or 1, a String
 * variable is the number of its slot in `text`. `memory` is one flat block without pointers that the adapter
 * allocates, saves, restores and serialises as bytes. Behind it lie as many bytes again, in which a step may keep what it
 * needs to leave no trace if it is refused; nothing else is to be expected there. */
#ifndef DS_MODEL_H
#define DS_MODEL_H

#include <stddef.h>

#include "ds_linkage.h"
#include "ds_table.h"

#define DS_TEXT_SIZE 1024    /* bytes of a String variable, its end included */
#define DS_MESSAGE_SIZE 512  /* bytes of a message, its end included */

typedef char ds_text[DS_TEXT_SIZE];

typedef enum { DS_OK, DS_DISCARD, DS_FAILED } ds_result;

/* takes a sentence on what happened at a time */
typedef void ds_listener(void *owner, double time, const char *sentence);

/* where a model says what happened: `event` hears of all, `warning` of what limits the worth of the results; either is
 * null if nobody listens. `reason` receives the sentence that explains a refusal. */
typedef struct {
    void *owner;
    ds_listener *event;
    ds_listener *warning;
    char reason[DS_MESSAGE_SIZE];
} ds_journal;

/* bytes of `memory` with these parameters; 0 with a reason if it cannot be had */
DS_SHARED size_t ds_model_size(const double value[], const ds_text text[], ds_journal *journal);

/* conditions between several variables; DS_DISCARD with a reason if one does not hold */
DS_SHARED ds_result ds_model_check(const double value[], ds_journal *journal);

/* initialise `memory`, which has `size` bytes, at a time from parameters and inputs, which go on along slope[i]; writes
 * the outputs to `value` */
DS_SHARED ds_result ds_model_start(void *memory, size_t size, double value[], const double slope[],
                                   const ds_text text[], double time, ds_journal *journal);

/* go from `time` to `end` with inputs value[i] + slope[i] (t - time); writes the outputs to `value`.
 * With DS_DISCARD nothing has changed. */
DS_SHARED ds_result ds_model_step(void *memory, double value[], const double slope[], double time, double end,
                                  ds_journal *journal);

/* write the derivatives of the Real outputs by time, for which `rate` holds zeros: limits from the right after the start,
 * and after a step from the same side as the outputs */
DS_SHARED void ds_model_output_derivatives(const void *memory, double rate[]);

#if DS_PROVIDES_DIRECTIONAL_DERIVATIVE
/* write the derivatives of the Real outputs, for which `change` holds zeros, in the direction `seed`: at the start, of
 * inputs and parameters; after a step, of inputs, as far as they act at once. Where an output has a kink, the derivative
 * is that to the side of the seed; where it jumps, that of the branch it is on. */
DS_SHARED void ds_model_directional_derivatives(const void *memory, const double value[], const double seed[],
                                                int at_start, double change[]);
#endif

#endif
