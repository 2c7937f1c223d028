/* The plant as an FMU: values by value reference to and from the core. */
#include <math.h>
#include <stdio.h>

#include "ds_condition.h"
#include "ds_model.h"
#include "ds_neutral.h"
#include "ds_table.h"

#define MOST_BLOCKS_RUN 4503599627370496.0 /* 2^52: up to here a block number and a fraction of the block fit a double */

/* The memory holds the model and behind it the state, which ends in an array and so can be no member of a struct. */
static ds_neutral_state *state_of(ds_neutral *model)
{
    void *const behind = model + 1;
    return behind;
}

static ds_parameters parameters_of(const double value[])
{
    const ds_parameters p = {
        value[DS_G],   value[DS_J],   value[DS_I],   value[DS_L],     value[DS_I_B],   value[DS_c_a],
        value[DS_R_b], value[DS_v_f], value[DS_c_b], value[DS_mu_cb], value[DS_mu_sb], value[DS_gamma_b],
    };
    return p;
}

size_t ds_model_size(const double value[], const ds_text text[], ds_journal *journal)
{
    const ds_parameters p = parameters_of(value);
    const double cells = value[DS_cells] > 0.0 ? value[DS_cells] : p.L * sqrt(p.I / (p.G * p.J)) / DS_CELL_LIMIT;
    (void)text;
    if (cells > 1e7) {
        snprintf(journal->reason, sizeof journal->reason,
                 "the travel time of the string asks for %.3g cells; expected at most 1e7: set cells or a shorter L",
                 cells);
        return 0;
    }
    return sizeof(ds_neutral) + ds_neutral_state_size(ds_neutral_cells(&p, (int)value[DS_cells]));
}

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    return ds_at_least("mu_sb", value[DS_mu_sb], "mu_cb", value[DS_mu_cb], journal);
}

static void write_outputs(const ds_neutral *model, const ds_neutral_state *state, double value[])
{
    ds_neutral_outputs o;
    ds_neutral_read(model, state, &o);
    value[DS_bit_speed] = o.bit_speed;
    value[DS_top_speed] = o.top_speed;
    value[DS_bit_torque] = o.bit_torque;
    value[DS_top_torque] = o.top_torque;
    value[DS_bit_angle] = o.bit_angle;
    value[DS_top_angle] = o.top_angle;
    value[DS_bit_stuck] = o.bit_stuck;
    value[DS_energy] = o.energy;
    value[DS_bit_speed_min] = o.bit_speed_min;
    value[DS_bit_speed_max] = o.bit_speed_max;
    value[DS_stuck_time] = o.stuck_time;
    value[DS_slip_count] = o.slip_count;
    value[DS_last_stop_time] = o.last_stop_time;
    value[DS_last_release_time] = o.last_release_time;
    value[DS_work_in] = o.work_in;
    value[DS_bit_loss] = o.bit_loss;
    value[DS_cells_used] = o.cells_used;
    value[DS_breaks_folded] = o.breaks_folded;
    value[DS_folded_energy] = o.folded_energy;
}

/* what the events of a step are told from, as it was before the step */
typedef struct {
    double slip_count, last_stop_time, breaks_folded;
} history;

static void tell_release(const double value[], const history *before, ds_journal *journal)
{
    char sentence[DS_MESSAGE_SIZE];
    if (value[DS_slip_count] > before->slip_count) {
        snprintf(sentence, sizeof sentence, "the bit breaks loose, release number %.0f", value[DS_slip_count]);
        journal->event(journal->owner, value[DS_last_release_time], sentence);
    }
}

static void tell_stop(const double value[], const history *before, ds_journal *journal)
{
    if (value[DS_last_stop_time] > before->last_stop_time) {
        journal->event(journal->owner, value[DS_last_stop_time], "the bit sticks");
    }
}

/* say that the bit has stopped or broken loose since `before`, in the order of time; of several stops, the last */
static void tell_events(const double value[], const history *before, double end, ds_journal *journal)
{
    if (journal->event != NULL && value[DS_last_stop_time] < value[DS_last_release_time]) {
        tell_stop(value, before, journal);
        tell_release(value, before, journal);
    } else if (journal->event != NULL) {
        tell_release(value, before, journal);
        tell_stop(value, before, journal);
    }
    if (journal->warning != NULL && before->breaks_folded == 0.0 && value[DS_breaks_folded] > 0.0) {
        journal->warning(journal->owner, end, "more breaks are under way than can be kept: the weakest are folded");
    }
}

ds_result ds_model_start(void *memory, size_t size, double value[], const ds_text text[], double time,
                         ds_journal *journal)
{
    ds_neutral *const model = memory;
    ds_neutral_state *const state = state_of(model);
    const ds_parameters p = parameters_of(value);
    const history before = {value[DS_slip_count], time, 0.0}; /* a start may be repeated */
    (void)size;
    (void)text;
    ds_neutral_build(model, &p, (int)value[DS_cells], time);
    ds_neutral_start(model, state, value[DS_initial_speed], value[DS_initial_torque], value[DS_Omega], value[DS_WOB]);
    write_outputs(model, state, value);
    tell_events(value, &before, time, journal);
    return DS_OK;
}

ds_result ds_model_step(void *memory, double value[], const double slope[], double time, double end,
                        ds_journal *journal)
{
    ds_neutral *const model = memory;
    ds_neutral_state *const state = state_of(model);
    const history before = {value[DS_slip_count], value[DS_last_stop_time], value[DS_breaks_folded]};
    (void)time;
    if ((end - model->clock.start) / model->clock.block > MOST_BLOCKS_RUN) {
        snprintf(journal->reason, sizeof journal->reason,
                 "the step ends at %.9g s; expected at most %.9g s, as far as blocks of %.3g s can be counted", end,
                 model->clock.start + MOST_BLOCKS_RUN * model->clock.block, model->clock.block);
        return DS_DISCARD;
    }
    const ds_parameters p = parameters_of(value);
    const ds_parameters *const old = &model->parameters;
    if (p.c_b != old->c_b || p.mu_cb != old->mu_cb || p.mu_sb != old->mu_sb || p.gamma_b != old->gamma_b) {
        ds_neutral_set_friction(model, state, &p);
        model->parameters = p;
    }
    ds_neutral_set_inputs(model, state, value[DS_Omega], value[DS_WOB], slope[DS_Omega], slope[DS_WOB]);
    ds_neutral_advance(model, state, end);
    write_outputs(model, state, value);
    tell_events(value, &before, end, journal);
    return DS_OK;
}
