#include "ds_plant.h"

#include <math.h>
#include <stdio.h>

#include "ds_friction_table.h"
#include "ds_table.h"
#include "ds_work.h"

#define MOST_BLOCKS_RUN 4503599627370496.0 /* 2^52: up to here a block number and a fraction of the block fit a double */

ds_parameters ds_plant_parameters(const double value[])
{
    const ds_parameters p = {
        value[DS_G], value[DS_J], value[DS_I], value[DS_L], value[DS_I_B], value[DS_c_a], ds_friction_read(value),
    };
    return p;
}

int ds_plant_cells(const double value[], ds_journal *journal)
{
    const ds_parameters p = ds_plant_parameters(value);
    const double cells = value[DS_cells] > 0.0 ? value[DS_cells] : p.L * sqrt(p.I / (p.G * p.J)) / DS_CELL_LIMIT;
    if (cells > 1e7) {
        snprintf(journal->reason, sizeof journal->reason,
                 "the travel time of the string asks for %.3g cells; expected at most 1e7: set cells or a shorter L",
                 cells);
        return 0;
    }
    return ds_neutral_cells(&p, (int)value[DS_cells]);
}

int ds_plant_affords(const ds_parameters *parameters, double beta, int blocks, int cells, ds_journal *journal)
{
    const ds_parameters *const p = parameters;
    const ds_work work = {
        p->L * sqrt(p->I / (p->G * p->J)), sqrt(p->I * p->G * p->J) + p->friction.c_b, p->I_B, blocks,
        ds_clock_blocks(cells), beta,
    };
    const double times = ds_work_times(&work);
    if (times <= DS_MOST_ASKED) {
        return 1;
    }
    snprintf(journal->reason, sizeof journal->reason,
             "a second takes %.4g times the work of the start values; expected at most %g: set %s", times,
             DS_MOST_ASKED, ds_work_remedy(&work));
    return 0;
}

void ds_plant_spent(const ds_clock *clock, const ds_bit *bit, ds_journal *journal)
{
    snprintf(journal->reason, sizeof journal->reason,
             "at t = %.9g s the bit moves so fast that a second takes more than %g times the work of the start values: "
             "set a greater I_B, or change torque and weight less",
             ds_clock_time(clock, bit->block, bit->begin), DS_MOST_TIMES);
}

int ds_plant_reaches(const ds_clock *clock, double end, ds_journal *journal)
{
    if ((end - clock->start) / clock->block > MOST_BLOCKS_RUN) {
        snprintf(journal->reason, sizeof journal->reason,
                 "the step ends at %.9g s; expected at most %.9g s, as far as blocks of %.3g s can be counted", end,
                 clock->start + MOST_BLOCKS_RUN * clock->block, clock->block);
        return 0;
    }
    return 1;
}

int ds_plant_tuned(const ds_parameters *old, const ds_parameters *parameters)
{
    return !ds_friction_same(&parameters->friction, &old->friction);
}

ds_plant_history ds_plant_before(const double value[])
{
    const ds_plant_history before = {value[DS_slip_count], value[DS_last_stop_time], value[DS_breaks_folded]};
    return before;
}

static void tell_release(const double value[], const ds_plant_history *before, ds_journal *journal)
{
    char sentence[DS_MESSAGE_SIZE];
    if (value[DS_slip_count] > before->slip_count) {
        snprintf(sentence, sizeof sentence, "the bit breaks loose, release number %.0f", value[DS_slip_count]);
        journal->event(journal->owner, value[DS_last_release_time], sentence);
    }
}

static void tell_stop(const double value[], const ds_plant_history *before, ds_journal *journal)
{
    if (value[DS_last_stop_time] > before->last_stop_time) {
        journal->event(journal->owner, value[DS_last_stop_time], "the bit sticks");
    }
}

void ds_plant_tell(const double value[], const ds_plant_history *before, double end, ds_journal *journal)
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

void ds_plant_differentiate(const ds_top_law *top, const ds_neutral_state *state, const double seed[], double change[])
{
    change[DS_top_speed] = top->transmission * seed[DS_Omega];
    change[DS_top_torque] = top->sliding * (seed[DS_Omega] - change[DS_top_speed]);
    change[DS_bit_torque] = ds_neutral_torque_by_weight(state) * seed[DS_WOB];
}

/* how much the torque on bit of eqs. (3) and (4) changes with its speed, weight and parameters in a slip */
static double slip_torque_change(const double value[], const double seed[], int direction)
{
    const ds_friction_parameters parameters = ds_friction_read(value);
    const ds_friction_parameters parameters_seed = ds_friction_read(seed);
    const ds_friction_motion motion = {value[DS_WOB], value[DS_initial_speed]};
    const ds_friction_motion motion_seed = {seed[DS_WOB], seed[DS_initial_speed]};
    return ds_friction_torque_change(&parameters, motion, direction, &parameters_seed, motion_seed);
}

void ds_plant_differentiate_start(double impedance, int direction, ds_plant_drag drag, const double value[],
                                  const double seed[], double change[])
{
    const double stiffness = value[DS_G] * value[DS_J];
    const double stiffer = seed[DS_G] / value[DS_G] + seed[DS_J] / value[DS_J]; /* relative change of G J */
    const double impedance_change = 0.5 * impedance * (seed[DS_I] / value[DS_I] + stiffer);
    const double speed = value[DS_initial_speed];
    const double speed_change = seed[DS_initial_speed];
    const double torque = value[DS_initial_torque];
    const double torque_change = seed[DS_initial_torque];
    const double mean = torque + 0.5 * drag.torque;
    const double mean_change = torque_change + 0.5 * drag.change;
    const double square = torque * torque + torque * drag.torque + drag.torque * drag.torque / 3.0;
    const double square_change = 2.0 * torque * torque_change + torque * drag.change + torque_change * drag.torque +
                                 2.0 * drag.torque * drag.change / 3.0;
    const double slip = value[DS_Omega] - value[DS_top_speed];
    change[DS_bit_speed] = speed_change;
    change[DS_bit_speed_min] = speed_change;
    change[DS_bit_speed_max] = speed_change;
    /* (c_a + Z) top_speed = c_a Omega + Z v_0 - the torque at the top */
    change[DS_top_speed] = (seed[DS_c_a] * slip + value[DS_c_a] * seed[DS_Omega] + impedance * speed_change +
                            impedance_change * (speed - value[DS_top_speed]) - (torque_change + drag.change)) /
                           (value[DS_c_a] + impedance);
    change[DS_top_torque] = seed[DS_c_a] * slip + value[DS_c_a] * (seed[DS_Omega] - change[DS_top_speed]);
    change[DS_bit_torque] = direction == 0 ? torque_change : slip_torque_change(value, seed, direction);
    change[DS_top_angle] = (mean_change * value[DS_L] + mean * (seed[DS_L] - value[DS_L] * stiffer)) / stiffness;
    change[DS_energy] = 0.5 * (seed[DS_L] * value[DS_I] + value[DS_L] * seed[DS_I] + seed[DS_I_B]) * speed * speed +
                        (value[DS_L] * value[DS_I] + value[DS_I_B]) * speed * speed_change +
                        0.5 * (square_change * value[DS_L] + square * (seed[DS_L] - value[DS_L] * stiffer)) / stiffness;
}
