/* The friction parameters in the table of a model that has them. */
#ifndef DS_FRICTION_TABLE_H
#define DS_FRICTION_TABLE_H

#include "ds_condition.h"
#include "ds_friction.h"
#include "ds_table.h"

static inline ds_friction_parameters ds_friction_read(const double value[])
{
    const ds_friction_parameters p = {
        value[DS_R_b], value[DS_v_f], value[DS_c_b], value[DS_mu_cb], value[DS_mu_sb], value[DS_gamma_b],
    };
    return p;
}

/* DS_DISCARD with a reason if the parameters contradict each other */
static inline ds_result ds_friction_check(const double value[], ds_journal *journal)
{
    return ds_at_least("mu_sb", value[DS_mu_sb], "mu_cb", value[DS_mu_cb], journal);
}

#endif
