/* A table on spring and damper at the top of the string. Follows models/controllers/virtual_drive.py, which explains it. */
#include "ds_virtual_drive_law.h"

enum { MODE_TUNED = 1, MODE_OWN = 2 };

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    (void)value;
    (void)journal;
    return DS_OK;
}

static ds_gains gains_of(const double value[])
{
    const ds_gains own = {value[DS_c_f], value[DS_k_f], value[DS_J_a]};
    return (int)value[DS_mode] == MODE_OWN ? own : ds_absorber(value);
}
