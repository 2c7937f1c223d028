/* Conditions between two variables of a model, which the ranges of its table cannot state. */
#ifndef DS_CONDITION_H
#define DS_CONDITION_H

#include <stdio.h>

#include "ds_model.h"
#include "ds_number.h"

/* DS_DISCARD with a reason if the first of two named values is below the second */
static inline ds_result ds_at_least(const char *name, double value, const char *least_name, double least,
                                    ds_journal *journal)
{
    if (value >= least) {
        return DS_OK;
    }
    const ds_number_text found = ds_number(value);
    const ds_number_text expected = ds_number(least);
    snprintf(journal->reason, sizeof journal->reason, "%s is %s; expected at least %s = %s", name, found.text,
             least_name, expected.text);
    return DS_DISCARD;
}

#endif
