/* How fast the outputs of the plant change at the present, and how the inputs act on them at once. Read off the
 * polynomials as the outputs are: limits from the left after a step, from the right after the start. */
#ifndef DS_NEUTRAL_RATE_H
#define DS_NEUTRAL_RATE_H

#include "ds_linkage.h"
#include "ds_neutral.h"

/* write the derivatives of the outputs by time for which `rate` holds zeros; those of the other outputs stay zero */
DS_SHARED void ds_neutral_read_rates(const ds_neutral *model, const ds_neutral_state *state, double rate[]);
/* derivative of the torque on bit by the weight on bit at the present speed [m], 0 while the bit is stuck */
DS_SHARED double ds_neutral_torque_by_weight(const ds_neutral_state *state);

#endif
