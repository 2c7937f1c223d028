/* How fast the outputs of the damped plant change at the present. */
#ifndef DS_DISTRIBUTED_RATE_H
#define DS_DISTRIBUTED_RATE_H

#include "ds_distributed.h"
#include "ds_linkage.h"
#include "ds_neutral_rate.h"

/* write the derivatives by time of the outputs that the neutral plant has as well; returns that of the loss along the
 * string [W] */
DS_SHARED double ds_distributed_read_rates(const ds_distributed *model, const ds_distributed_state *state,
                                           double rate[]);
/* of what is read at a station [rad/s2, N m/s, rad/s] */
DS_SHARED ds_station_outputs ds_distributed_station_rate(const ds_distributed *model,
                                                         const ds_distributed_state *state, int number);

#endif
