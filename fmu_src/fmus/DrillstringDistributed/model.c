/* The plant with damping along the string as an FMU. */
#include <stdio.h>

#include "ds_distributed.h"
#include "ds_distributed_rate.h"
#include "ds_friction_table.h"
#include "ds_model.h"
#include "ds_plant.h"
#include "ds_table.h"

/* the outputs of a station stand together in the table, and the stations one after the other */
enum { STATION_STRIDE = DS_station_2_speed - DS_station_1_speed };

static void write_station(double value[], int number, ds_station_outputs station)
{
    const int first = number * STATION_STRIDE;
    value[DS_station_1_speed + first] = station.speed;
    value[DS_station_1_torque + first] = station.torque;
    value[DS_station_1_twist + first] = station.twist;
}

static ds_distributed_state *state_of(ds_distributed *model)
{
    void *const behind = model + 1;
    return behind;
}

static const ds_distributed_state *state_in(const ds_distributed *model)
{
    const void *const behind = model + 1;
    return behind;
}

size_t ds_model_size(const double value[], const ds_text text[], ds_journal *journal)
{
    const ds_parameters p = ds_plant_parameters(value);
    const int cells = ds_plant_cells(value, journal);
    const double damping = ds_distributed_damping_cells(&p, value[DS_beta]);
    (void)text;
    if (cells == 0) {
        return 0;
    }
    if (damping > 1e7) {
        snprintf(journal->reason, sizeof journal->reason,
                 "the damping asks for %.3g cells; expected at most 1e7: set a lower beta or a shorter L", damping);
        return 0;
    }
    const int blocks = ds_distributed_blocks(&p, value[DS_beta], cells, (int)value[DS_stations]);
    if (!ds_plant_affords(&p, value[DS_beta], blocks, cells, journal)) {
        return 0;
    }
    return sizeof(ds_distributed) + ds_distributed_state_size(blocks);
}

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    return ds_friction_check(value, journal);
}

static void write_outputs(const ds_distributed *model, const ds_distributed_state *state, double value[])
{
    ds_distributed_read(model, state, value);
    value[DS_string_loss] = ds_distributed_string_loss(model, state);
    for (int i = 0; i + 1 < model->parts; ++i) {
        write_station(value, i, ds_distributed_station(model, state, i, value[DS_top_angle]));
    }
}

/* a start may follow one with more stations */
static void clear_stations(double value[])
{
    const ds_station_outputs none = {0.0, 0.0, 0.0};
    for (int i = 0; i < DS_MOST_stations; ++i) {
        write_station(value, i, none);
    }
}

ds_result ds_model_start(void *memory, size_t size, double value[], const double slope[], const ds_text text[],
                         double time, ds_journal *journal)
{
    ds_distributed *const model = memory;
    ds_distributed_state *const state = state_of(model);
    const ds_parameters p = ds_plant_parameters(value);
    const ds_plant_history before = {value[DS_slip_count], time, 0.0}; /* a start may be repeated */
    (void)size;
    (void)text;
    ds_distributed_build(model, &p, value[DS_beta], (int)value[DS_cells], (int)value[DS_stations], time);
    ds_distributed_start(model, state, value[DS_initial_speed], value[DS_initial_torque], value[DS_Omega],
                         value[DS_WOB]);
    ds_distributed_set_inputs(model, state, value[DS_Omega], value[DS_WOB], slope[DS_Omega], slope[DS_WOB]);
    clear_stations(value);
    write_outputs(model, state, value);
    ds_plant_tell(value, &before, time, journal);
    return DS_OK;
}

ds_result ds_model_step(void *memory, double value[], const double slope[], double time, double end,
                        ds_journal *journal)
{
    ds_distributed *const model = memory;
    ds_distributed_state *const state = state_of(model);
    const ds_plant_history before = ds_plant_before(value);
    (void)time;
    if (!ds_plant_reaches(&model->string.clock, end, journal)) {
        return DS_DISCARD;
    }
    const ds_parameters p = ds_plant_parameters(value);
    const int tuned = ds_plant_tuned(&model->string.parameters, &p);
    if (tuned && !ds_plant_affords(&p, model->beta, model->string.blocks, model->string.cells, journal)) {
        return DS_DISCARD;
    }
    ds_distributed_keep(state);
    if (tuned) {
        ds_distributed_set_friction(model, state, &p);
    }
    ds_distributed_set_inputs(model, state, value[DS_Omega], value[DS_WOB], slope[DS_Omega], slope[DS_WOB]);
    if (!ds_distributed_advance(model, state, end)) {
        ds_plant_spent(&model->string.clock, &ds_distributed_string(state)->bit, journal);
        ds_distributed_put_back(state);
        return DS_DISCARD;
    }
    ds_neutral_let_go(ds_distributed_string(state));
    if (tuned) {
        model->string.parameters = p;
    }
    write_outputs(model, state, value);
    ds_plant_tell(value, &before, end, journal);
    return DS_OK;
}

void ds_model_output_derivatives(const void *memory, double rate[])
{
    const ds_distributed *const model = memory;
    const ds_distributed_state *const state = state_in(model);
    rate[DS_string_loss] = ds_distributed_read_rates(model, state, rate);
    for (int i = 0; i + 1 < model->parts; ++i) {
        write_station(rate, i, ds_distributed_station_rate(model, state, i));
    }
}

/* how much what is read at the stations at the start changes */
static void differentiate_stations(const ds_distributed *model, ds_plant_drag drag, const double value[],
                                   const double seed[], double change[])
{
    const double stiffness = value[DS_G] * value[DS_J];
    const double stiffer = seed[DS_G] / value[DS_G] + seed[DS_J] / value[DS_J];
    for (int i = 0; i + 1 < model->parts; ++i) {
        const double depth = (double)(i + 1) / model->parts;
        const double share = depth - 0.5 * depth * depth;
        const double twist = value[DS_initial_torque] * depth + drag.torque * share; /* times L / (G J) */
        const double twist_change = seed[DS_initial_torque] * depth + drag.change * share;
        const ds_station_outputs station = {
            seed[DS_initial_speed],
            seed[DS_initial_torque] + drag.change * (1.0 - depth),
            (twist_change * value[DS_L] + twist * (seed[DS_L] - value[DS_L] * stiffer)) / stiffness,
        };
        write_station(change, i, station);
    }
}

void ds_model_directional_derivatives(const void *memory, const double value[], const double seed[], int at_start,
                                      double change[])
{
    const ds_distributed *const model = memory;
    const ds_neutral_state *const string = ds_distributed_string_in(state_in(model));
    const double speed = value[DS_initial_speed];
    const ds_plant_drag drag = {
        value[DS_beta] * speed * value[DS_L],
        (seed[DS_beta] * speed + value[DS_beta] * seed[DS_initial_speed]) * value[DS_L] +
            value[DS_beta] * speed * seed[DS_L],
    };
    if (!at_start) {
        ds_plant_differentiate(&model->string.top, string, seed, change);
        return;
    }
    ds_plant_differentiate_start(model->string.impedance, string->bit.direction, drag, value, seed, change);
    differentiate_stations(model, drag, value, seed, change);
}
