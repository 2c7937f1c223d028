/* The plant as an FMU. */
#include "ds_friction_table.h"
#include "ds_model.h"
#include "ds_neutral.h"
#include "ds_neutral_rate.h"
#include "ds_plant.h"
#include "ds_table.h"

/* The memory holds the model and behind it the state, which ends in an array and so can be no member of a struct. */
static ds_neutral_state *state_of(ds_neutral *model)
{
    void *const behind = model + 1;
    return behind;
}

static const ds_neutral_state *state_in(const ds_neutral *model)
{
    const void *const behind = model + 1;
    return behind;
}

size_t ds_model_size(const double value[], const ds_text text[], ds_journal *journal)
{
    const ds_parameters p = ds_plant_parameters(value);
    const int cells = ds_plant_cells(value, journal);
    const int blocks = ds_clock_blocks(cells);
    (void)text;
    if (cells == 0 || !ds_plant_affords(&p, 0.0, blocks, cells, journal)) {
        return 0;
    }
    return sizeof(ds_neutral) + ds_neutral_state_size(blocks);
}

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    return ds_friction_check(value, journal);
}

ds_result ds_model_start(void *memory, size_t size, double value[], const double slope[], const ds_text text[],
                         double time, ds_journal *journal)
{
    ds_neutral *const model = memory;
    ds_neutral_state *const state = state_of(model);
    const ds_parameters p = ds_plant_parameters(value);
    const ds_plant_history before = {value[DS_slip_count], time, 0.0}; /* a start may be repeated */
    (void)size;
    (void)text;
    ds_neutral_build(model, &p, (int)value[DS_cells], time);
    ds_neutral_start(model, state, value[DS_initial_speed], value[DS_initial_torque], value[DS_Omega], value[DS_WOB]);
    ds_neutral_set_inputs(model, state, value[DS_Omega], value[DS_WOB], slope[DS_Omega], slope[DS_WOB]);
    ds_neutral_read(model, state, value);
    ds_plant_tell(value, &before, time, journal);
    return DS_OK;
}

ds_result ds_model_step(void *memory, double value[], const double slope[], double time, double end,
                        ds_journal *journal)
{
    ds_neutral *const model = memory;
    ds_neutral_state *const state = state_of(model);
    const ds_plant_history before = ds_plant_before(value);
    (void)time;
    if (!ds_plant_reaches(&model->clock, end, journal)) {
        return DS_DISCARD;
    }
    const ds_parameters p = ds_plant_parameters(value);
    const int tuned = ds_plant_tuned(&model->parameters, &p);
    if (tuned && !ds_plant_affords(&p, 0.0, model->blocks, model->cells, journal)) {
        return DS_DISCARD;
    }
    ds_neutral_keep(state);
    if (tuned) {
        ds_neutral_set_friction(model, state, &p);
    }
    ds_neutral_set_inputs(model, state, value[DS_Omega], value[DS_WOB], slope[DS_Omega], slope[DS_WOB]);
    if (!ds_neutral_advance(model, state, end)) {
        ds_plant_spent(&model->clock, &state->bit, journal);
        ds_neutral_put_back(state);
        return DS_DISCARD;
    }
    ds_neutral_let_go(state);
    if (tuned) {
        model->parameters = p;
    }
    ds_neutral_read(model, state, value);
    ds_plant_tell(value, &before, end, journal);
    return DS_OK;
}

void ds_model_output_derivatives(const void *memory, double rate[])
{
    const ds_neutral *const model = memory;
    ds_neutral_read_rates(model, state_in(model), rate);
}

void ds_model_directional_derivatives(const void *memory, const double value[], const double seed[], int at_start,
                                      double change[])
{
    const ds_neutral *const model = memory;
    const ds_neutral_state *const state = state_in(model);
    const ds_plant_drag none = {0.0, 0.0};
    if (at_start) {
        ds_plant_differentiate_start(model->impedance, state->bit.direction, none, value, seed, change);
        return;
    }
    ds_plant_differentiate(&model->top, state, seed, change);
}
