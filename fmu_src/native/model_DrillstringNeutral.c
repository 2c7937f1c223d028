/* The plant as an FMU: values by value reference to and from the core. */
#include <math.h>
#include <stdio.h>

#include "ds_condition.h"
#include "ds_exp.h"
#include "ds_model.h"
#include "ds_neutral.h"
#include "ds_neutral_rate.h"
#include "ds_table.h"

#define MOST_BLOCKS_RUN 4503599627370496.0 /* 2^52: up to here a block number and a fraction of the block fit a double */

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
    value[DS_drive_work] = o.drive_work;
    value[DS_top_loss] = o.top_loss;
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

ds_result ds_model_start(void *memory, size_t size, double value[], const double slope[], const ds_text text[],
                         double time, ds_journal *journal)
{
    ds_neutral *const model = memory;
    ds_neutral_state *const state = state_of(model);
    const ds_parameters p = parameters_of(value);
    const history before = {value[DS_slip_count], time, 0.0}; /* a start may be repeated */
    (void)size;
    (void)text;
    ds_neutral_build(model, &p, (int)value[DS_cells], time);
    ds_neutral_start(model, state, value[DS_initial_speed], value[DS_initial_torque], value[DS_Omega], value[DS_WOB]);
    ds_neutral_set_inputs(model, state, value[DS_Omega], value[DS_WOB], slope[DS_Omega], slope[DS_WOB]);
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

void ds_model_output_derivatives(const void *memory, double rate[])
{
    const ds_neutral *const model = memory;
    ds_neutral_rates r;
    ds_neutral_read_rates(model, state_in(model), &r);
    rate[DS_bit_speed] = r.bit_speed;
    rate[DS_top_speed] = r.top_speed;
    rate[DS_bit_torque] = r.bit_torque;
    rate[DS_top_torque] = r.top_torque;
    rate[DS_bit_angle] = r.bit_angle;
    rate[DS_top_angle] = r.top_angle;
    rate[DS_energy] = r.energy;
    rate[DS_bit_speed_min] = r.bit_speed_min;
    rate[DS_bit_speed_max] = r.bit_speed_max;
    rate[DS_stuck_time] = r.stuck_time;
    rate[DS_work_in] = r.work_in;
    rate[DS_bit_loss] = r.bit_loss;
    rate[DS_drive_work] = r.drive_work;
    rate[DS_top_loss] = r.top_loss;
}

/* how much the torque on bit of eqs. (3) and (4) changes with its speed, weight and parameters in a slip */
static double slip_torque_change(const double value[], const double seed[], int direction)
{
    const double speed = value[DS_initial_speed];
    const double speed_change = seed[DS_initial_speed];
    const double excess = value[DS_mu_sb] - value[DS_mu_cb];
    const double exponent = value[DS_gamma_b] * fabs(speed) / value[DS_v_f];
    const double fading = ds_exp(-exponent);
    const double exponent_change = (seed[DS_gamma_b] * fabs(speed) + value[DS_gamma_b] * direction * speed_change -
                                    exponent * seed[DS_v_f]) / value[DS_v_f];
    const double mu = value[DS_mu_cb] + excess * fading;
    const double mu_change = seed[DS_mu_cb] + (seed[DS_mu_sb] - seed[DS_mu_cb] - excess * exponent_change) * fading;
    const double dry_change = seed[DS_WOB] * value[DS_R_b] * mu + value[DS_WOB] * seed[DS_R_b] * mu +
                              value[DS_WOB] * value[DS_R_b] * mu_change;
    return seed[DS_c_b] * speed + value[DS_c_b] * speed_change + direction * dry_change;
}

/* how much the outputs at the start change with all they are made from: see model 8 for what is before it */
static void differentiate_start(const ds_neutral *model, const double value[], const double seed[], double change[])
{
    const double impedance = model->impedance;
    const double stiffer = seed[DS_G] / value[DS_G] + seed[DS_J] / value[DS_J]; /* relative change of G J */
    const double impedance_change = 0.5 * impedance * (seed[DS_I] / value[DS_I] + stiffer);
    const double speed = value[DS_initial_speed];
    const double speed_change = seed[DS_initial_speed];
    const double torque = value[DS_initial_torque];
    const double twist = torque / (value[DS_G] * value[DS_J]); /* rad/m */
    const double twist_change = seed[DS_initial_torque] / (value[DS_G] * value[DS_J]) - twist * stiffer;
    const double slip = value[DS_Omega] - value[DS_top_speed];
    const int direction = state_in(model)->bit.direction;
    change[DS_bit_speed] = speed_change;
    change[DS_bit_speed_min] = speed_change;
    change[DS_bit_speed_max] = speed_change;
    /* (c_a + Z) top_speed = c_a Omega + Z v_0 - tau_0 */
    change[DS_top_speed] = (seed[DS_c_a] * slip + value[DS_c_a] * seed[DS_Omega] + impedance * speed_change +
                            impedance_change * (speed - value[DS_top_speed]) - seed[DS_initial_torque]) /
                           (value[DS_c_a] + impedance);
    change[DS_top_torque] = seed[DS_c_a] * slip + value[DS_c_a] * (seed[DS_Omega] - change[DS_top_speed]);
    change[DS_bit_torque] = direction == 0 ? seed[DS_initial_torque] : slip_torque_change(value, seed, direction);
    change[DS_top_angle] = twist_change * value[DS_L] + twist * seed[DS_L];
    change[DS_energy] = 0.5 * (seed[DS_L] * value[DS_I] + value[DS_L] * seed[DS_I] + seed[DS_I_B]) * speed * speed +
                        (value[DS_L] * value[DS_I] + value[DS_I_B]) * speed * speed_change +
                        0.5 * (seed[DS_L] * torque * twist +
                               value[DS_L] * (seed[DS_initial_torque] * twist + torque * twist_change));
}

void ds_model_directional_derivatives(const void *memory, const double value[], const double seed[], int at_start,
                                      double change[])
{
    const ds_neutral *const model = memory;
    const ds_top_law *const top = &model->top;
    if (at_start) {
        differentiate_start(model, value, seed, change);
        return;
    }
    change[DS_top_speed] = top->transmission * seed[DS_Omega];
    change[DS_top_torque] = top->sliding * (seed[DS_Omega] - change[DS_top_speed]);
    change[DS_bit_torque] = ds_neutral_torque_by_weight(state_in(model)) * seed[DS_WOB];
}
