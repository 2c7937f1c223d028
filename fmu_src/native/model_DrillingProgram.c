/* The driller's program as an FMU. Follows models/program.py and models/friction.py. */
#include <math.h>

#include "ds_condition.h"
#include "ds_exp.h"
#include "ds_model.h"
#include "ds_program.h"
#include "ds_table.h"

typedef struct {
    size_t count; /* rows of the table, 0: the changes hold */
    ds_row rows[];
} block;

size_t ds_model_size(const double value[], const ds_text text[], ds_journal *journal)
{
    const char *const path = text[(int)value[DS_table]];
    if (path[0] == '\0') {
        return sizeof(block);
    }
    const size_t count = ds_table_read(path, NULL, 0, journal->reason, sizeof journal->reason);
    return count == 0 ? 0 : sizeof(block) + count * sizeof(ds_row);
}

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    return ds_at_least("mu_sb", value[DS_mu_sb], "mu_cb", value[DS_mu_cb], journal);
}

static ds_point speed_at(const block *program, const double value[], double time)
{
    const ds_change change = {value[DS_speed_initial], value[DS_speed_final], value[DS_speed_start],
                              value[DS_speed_duration]};
    return program->count > 0 ? ds_table_at(program->rows, program->count, time, 1) : ds_change_at(&change, time);
}

static ds_point weight_at(const block *program, const double value[], double time)
{
    const ds_change change = {value[DS_WOB_initial], value[DS_WOB_final], value[DS_WOB_start], value[DS_WOB_duration]};
    return program->count > 0 ? ds_table_at(program->rows, program->count, time, 2) : ds_change_at(&change, time);
}

/* torque on bit of eqs. (3) and (4) while the bit turns, 0 at rest */
static double torque_on_bit(const double value[], double weight, double speed)
{
    const double rate = value[DS_gamma_b] / value[DS_v_f];
    if (speed == 0.0) {
        return 0.0;
    }
    const double mu = value[DS_mu_cb] + (value[DS_mu_sb] - value[DS_mu_cb]) * ds_exp(-rate * fabs(speed));
    const double dry = weight * value[DS_R_b] * mu;
    return value[DS_c_b] * speed + (speed > 0.0 ? dry : -dry);
}

static void ask(const block *program, double value[], double time)
{
    const double speed = speed_at(program, value, time).value;
    const double weight = weight_at(program, value, time).value;
    value[DS_Omega] = speed;
    value[DS_speed_ref] = speed;
    value[DS_bit_speed_ref] = speed;
    value[DS_WOB] = weight;
    value[DS_bit_torque_ref] = torque_on_bit(value, weight, speed);
}

ds_result ds_model_start(void *memory, size_t size, double value[], const ds_text text[], double time,
                         ds_journal *journal)
{
    block *const program = memory;
    const char *const path = text[(int)value[DS_table]];
    program->count = 0;
    if (path[0] != '\0') {
        const size_t room = (size - sizeof(block)) / sizeof(ds_row);
        const size_t count = ds_table_read(path, program->rows, room, journal->reason, sizeof journal->reason);
        if (count == 0) {
            return DS_DISCARD;
        }
        program->count = count <= room ? count : room; /* the file may have grown since its rows were counted */
    }
    ask(program, value, time);
    return DS_OK;
}

ds_result ds_model_step(void *memory, double value[], const double slope[], double time, double end,
                        ds_journal *journal)
{
    (void)slope;
    (void)time;
    (void)journal;
    ask(memory, value, end);
    return DS_OK;
}

double ds_model_output_derivative(const void *memory, const double value[], double time, int variable)
{
    const block *const program = memory;
    const ds_point speed = speed_at(program, value, time);
    const ds_point weight = weight_at(program, value, time);
    const double magnitude = fabs(speed.value);
    const double rate = value[DS_gamma_b] / value[DS_v_f];
    const double fading = (value[DS_mu_sb] - value[DS_mu_cb]) * ds_exp(-rate * magnitude);
    switch (variable) {
    case DS_Omega:
    case DS_speed_ref:
    case DS_bit_speed_ref:
        return speed.slope;
    case DS_WOB:
        return weight.slope;
    default: /* the torque, by the product rule; its jump at rest has no derivative */
        if (speed.value == 0.0) {
            return 0.0;
        }
        return value[DS_c_b] * speed.slope - weight.value * value[DS_R_b] * rate * fading * speed.slope +
               (speed.value > 0.0 ? 1.0 : -1.0) * weight.slope * value[DS_R_b] * (value[DS_mu_cb] + fading);
    }
}
