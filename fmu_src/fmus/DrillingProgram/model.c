/* The driller's program as an FMU. Follows models/controllers/program.py and models/plant/friction.py. */
#include "ds_friction_table.h"
#include "ds_model.h"
#include "ds_program.h"
#include "ds_table.h"

typedef struct {
    size_t count;        /* rows of the table, 0: the changes hold */
    double speed_slope;  /* rad/s2, from now on */
    double weight_slope; /* N/s */
    double torque_slope; /* N m/s */
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
    return ds_friction_check(value, journal);
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
static ds_point torque_on_bit(const double value[], ds_point weight, ds_point speed)
{
    const ds_friction_parameters p = ds_friction_read(value);
    const ds_friction friction = ds_friction_of(&p, 1.0);
    const int direction = speed.value > 0.0 ? 1 : -1;
    ds_point torque = {0.0, 0.0};
    if (speed.value == 0.0) {
        return torque;
    }
    const ds_friction_point dry = ds_friction_at(&friction, weight.value * p.R_b, direction * speed.value);
    torque.value = p.c_b * speed.value + dry.torque * direction;
    torque.slope = (p.c_b + dry.slope) * speed.slope + direction * weight.slope * p.R_b * dry.arm;
    return torque;
}

static void ask(block *program, double value[], double time)
{
    const ds_point speed = speed_at(program, value, time);
    const ds_point weight = weight_at(program, value, time);
    const ds_point torque = torque_on_bit(value, weight, speed);
    value[DS_Omega] = speed.value;
    value[DS_speed_ref] = speed.value;
    value[DS_bit_speed_ref] = speed.value;
    value[DS_WOB] = weight.value;
    value[DS_bit_torque_ref] = torque.value;
    program->speed_slope = speed.slope;
    program->weight_slope = weight.slope;
    program->torque_slope = torque.slope;
}

ds_result ds_model_start(void *memory, size_t size, double value[], const double slope[], const ds_text text[],
                         double time, ds_journal *journal)
{
    block *const program = memory;
    const char *const path = text[(int)value[DS_table]];
    (void)slope;
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

void ds_model_output_derivatives(const void *memory, double rate[])
{
    const block *const program = memory;
    rate[DS_Omega] = program->speed_slope;
    rate[DS_speed_ref] = program->speed_slope;
    rate[DS_bit_speed_ref] = program->speed_slope;
    rate[DS_WOB] = program->weight_slope;
    rate[DS_bit_torque_ref] = program->torque_slope;
}
