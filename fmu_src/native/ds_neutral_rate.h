/* How fast the outputs of the plant change at the present, and how the inputs act on them at once. Read off the
 * polynomials as the outputs are: limits from the left after a step, from the right after the start. */
#ifndef DS_NEUTRAL_RATE_H
#define DS_NEUTRAL_RATE_H

#include "ds_linkage.h"
#include "ds_neutral.h"

/* derivatives of outputs by time; those of the other outputs are zero */
typedef struct {
    double bit_speed;     /* rad/s2 */
    double top_speed;     /* rad/s2 */
    double bit_torque;    /* N m/s */
    double top_torque;    /* N m/s */
    double bit_angle;     /* rad/s */
    double top_angle;     /* rad/s */
    double energy;        /* W, eq. (8) */
    double bit_speed_min; /* rad/s2 */
    double bit_speed_max; /* rad/s2 */
    double stuck_time;    /* 1 */
    double work_in;       /* W */
    double bit_loss;      /* W */
    double drive_work;    /* W */
    double top_loss;      /* W */
} ds_neutral_rates;

DS_SHARED void ds_neutral_read_rates(const ds_neutral *model, const ds_neutral_state *state, ds_neutral_rates *rates);
/* derivative of the torque on bit by the weight on bit at the present speed [m], 0 while the bit is stuck */
DS_SHARED double ds_neutral_torque_by_weight(const ds_neutral_state *state);

#endif
