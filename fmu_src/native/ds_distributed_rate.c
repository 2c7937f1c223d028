#include "ds_distributed_rate.h"

#include "ds_station.h"
#include "ds_table.h"

double ds_distributed_read_rates(const ds_distributed *model, const ds_distributed_state *state, double rate[])
{
    const ds_neutral *const m = &model->string;
    double now[DS_VARIABLES];
    ds_distributed_read(model, state, now);
    ds_neutral_read_rates(m, ds_distributed_string_in(state), rate);
    const double ends = now[DS_top_speed] * now[DS_top_speed] + now[DS_bit_speed] * now[DS_bit_speed];
    const double lost = state->last_loss / m->clock.block + model->exchange.strength * m->impedance * ends;
    rate[DS_energy] = rate[DS_energy] - lost;
    return lost;
}

ds_station_outputs ds_distributed_station_rate(const ds_distributed *model, const ds_distributed_state *state,
                                               int number)
{
    const ds_neutral_state *const s = ds_distributed_string_in(state);
    const ds_station_state *const station = &state->station[number];
    const ds_piece *const down_ring = s->ring + s->up.capacity;
    const double elapsed = ds_distributed_elapsed(s);
    const double strength = model->exchange.strength;
    const ds_station_reading now =
        ds_station_read(&s->up, s->ring, station->above, &s->down, down_ring, station->below, elapsed, strength);
    const ds_station_reading rate =
        ds_station_rate(&s->up, s->ring, station->above, &s->down, down_ring, station->below, elapsed, strength);
    double outputs[DS_VARIABLES];
    ds_neutral_read(&model->string, s, outputs);
    const double block = model->string.clock.block;
    const ds_station_outputs rates = {
        (rate.up + rate.down) / block,
        model->string.impedance * (rate.down - rate.up) / block,
        outputs[DS_top_speed] - (now.up + now.down),
    };
    return rates;
}
