#include "ds_neutral_rate.h"

#include <math.h>

#include "ds_table.h"

/* derivative by time of a quartic over a piece of a duration [s] */
static double rate_of(ds_quartic c, double x, double duration)
{
    return (c.c1 + x * (2.0 * c.c2 + x * (3.0 * c.c3 + x * (4.0 * c.c4)))) / duration;
}

static double bit_torque_rate(const ds_bit_law *law, const ds_bit *bit, double x, double duration)
{
    if (bit->direction == 0) {
        return law->twice_impedance * rate_of(bit->incident, x, duration);
    }
    const double acceleration = rate_of(bit->turning, x, duration);
    const double weight = bit->weight + x * bit->weight_rise;
    const ds_friction_point dry =
        ds_friction_at(&law->friction, weight, bit->direction * ds_quartic_value(bit->turning, x));
    return (law->viscosity + dry.slope) * acceleration + bit->direction * (bit->weight_rise / duration) * dry.arm;
}

void ds_neutral_read_rates(const ds_neutral *model, const ds_neutral_state *state, double rate[])
{
    const ds_bit *const bit = &state->bit;
    const ds_top *const top = &state->top;
    const double x = ds_neutral_present_in(state, bit->block, bit->begin, bit->end);
    const double y = ds_neutral_present_in(state, top->block, top->begin, top->end);
    const double bit_piece = (bit->end - bit->begin) * model->clock.block;
    const double top_piece = (top->end - top->begin) * model->clock.block;
    const double acceleration = rate_of(bit->turning, x, bit_piece);
    const double drive = ds_top_drive(&model->clock, top, y);
    double now[DS_VARIABLES];
    ds_neutral_read(model, state, now);
    rate[DS_bit_speed] = acceleration;
    rate[DS_top_speed] = rate_of(ds_top_speed(top), y, top_piece);
    rate[DS_bit_torque] = bit_torque_rate(&state->law, bit, x, bit_piece);
    rate[DS_top_torque] = model->top.sliding * (top->omega.slope - rate[DS_top_speed]);
    rate[DS_bit_angle] = now[DS_bit_speed];
    rate[DS_top_angle] = now[DS_top_speed];
    rate[DS_work_in] = now[DS_top_torque] * now[DS_top_speed];
    rate[DS_bit_loss] = now[DS_bit_torque] * now[DS_bit_speed];
    rate[DS_drive_work] = now[DS_top_torque] * drive;
    rate[DS_top_loss] = now[DS_top_torque] * (drive - now[DS_top_speed]);
    rate[DS_energy] = rate[DS_work_in] - rate[DS_bit_loss];
    rate[DS_stuck_time] = now[DS_bit_stuck];
    /* an extreme moves while the speed is at it and goes further */
    rate[DS_bit_speed_min] = now[DS_bit_speed] <= now[DS_bit_speed_min] ? fmin(acceleration, 0.0) : 0.0;
    rate[DS_bit_speed_max] = now[DS_bit_speed] >= now[DS_bit_speed_max] ? fmax(acceleration, 0.0) : 0.0;
}

double ds_neutral_torque_by_weight(const ds_neutral_state *state)
{
    const ds_bit *const bit = &state->bit;
    const double speed = ds_quartic_value(bit->turning, ds_neutral_present_in(state, bit->block, bit->begin, bit->end));
    return bit->direction * ds_friction_at(&state->law.friction, bit->weight, bit->direction * speed).arm;
}
