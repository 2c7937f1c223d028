/* Soft torque and impedance matching. Follows models/controllers/virtual_drive.py, which explains it. */
#include "ds_virtual_drive_law.h"

enum { MODE_SOFT_TORQUE = 1, MODE_Z_TORQUE = 2, MODE_OWN = 3 };

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    (void)value;
    (void)journal;
    return DS_OK;
}

static ds_gains gains_of(const double value[])
{
    const int mode = (int)value[DS_mode];
    const ds_gains own = {value[DS_P], value[DS_K], value[DS_J_v]};
    return mode == MODE_OWN ? own : ds_soft_torque(value, mode == MODE_Z_TORQUE ? 1.0 : 1.5);
}
