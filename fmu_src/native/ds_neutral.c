#include "ds_neutral.h"

#include <math.h>
#include <string.h>

#include "ds_table.h"
#include "ds_work.h"

int ds_neutral_cells(const ds_parameters *parameters, int requested)
{
    if (requested > 0) {
        return requested >= 4 ? requested : 4;
    }
    const double travel_time = parameters->L * sqrt(parameters->I / (parameters->G * parameters->J));
    int count = (int)(travel_time / DS_CELL_LIMIT);
    if (count * DS_CELL_LIMIT < travel_time) {
        count += 1;
    }
    return count >= 4 ? count : 4;
}

size_t ds_neutral_state_size(int blocks)
{
    return sizeof(ds_neutral_state) + 2 * (size_t)ds_line_capacity(blocks) * sizeof(ds_piece);
}

ds_bit_law ds_neutral_bit_law(const ds_parameters *parameters, double impedance)
{
    ds_bit_law law;
    law.twice_impedance = 2.0 * impedance;
    law.damping = impedance + parameters->friction.c_b;
    law.viscosity = parameters->friction.c_b;
    law.inertia = parameters->I_B;
    law.friction = ds_friction_of(&parameters->friction, parameters->friction.R_b);
    return law;
}

void ds_neutral_build(ds_neutral *model, const ds_parameters *parameters, int cells, double start)
{
    const ds_parameters *const p = parameters;
    model->parameters = *p;
    model->impedance = sqrt(p->I * p->G * p->J);
    model->top.reflection = (p->c_a - model->impedance) / (p->c_a + model->impedance);
    model->top.transmission = p->c_a / (p->c_a + model->impedance);
    model->top.sliding = p->c_a;
    model->cells = ds_neutral_cells(p, cells);
    model->clock.start = start;
    model->earning = ds_work_earning(0.0, 0.0, 0);
    ds_neutral_divide(model, ds_clock_blocks(model->cells));
}

void ds_neutral_divide(ds_neutral *model, int blocks)
{
    const ds_parameters *const p = &model->parameters;
    model->blocks = blocks;
    model->clock.block = p->L * sqrt(p->I / (p->G * p->J)) / blocks;
}

static void open_top(const ds_neutral *model, ds_neutral_state *state)
{
    ds_top_open(&model->top, &model->clock, &state->top, &state->up, state->ring);
}

static void open_bit(const ds_neutral *model, ds_neutral_state *state)
{
    ds_bit_open(&state->law, &model->clock, &state->bit, &state->down, ds_neutral_down_ring(state));
}

void ds_neutral_fill(const ds_neutral *model, ds_neutral_state *state, double initial_speed, double initial_torque,
                     double omega, double weight)
{
    const ds_parameters *const p = &model->parameters;
    const double twist = initial_torque / (2.0 * model->impedance);
    const double coarseness = ds_clock_coarseness(&model->clock);
    const ds_ramp drive = {{0, 0.0}, omega, 0.0};
    const ds_ramp wob = {{0, 0.0}, weight, 0.0};
    const ds_place start = {0, 0.0};
    state->law = ds_neutral_bit_law(p, model->impedance);
    ds_line_fill(&state->up, state->ring, model->blocks, 0.5 * initial_speed - twist, coarseness);
    ds_line_fill(&state->down, ds_neutral_down_ring(state), model->blocks, 0.5 * initial_speed + twist, coarseness);
    ds_top_start(&state->top, initial_torque / (p->G * p->J / p->L));
    state->top.omega = drive;
    ds_bit_start(&state->bit, &model->clock, initial_speed);
    ds_bit_endow(&state->bit, model->earning);
    state->bit.wob = wob;
    state->present = start;
    state->least = initial_speed;
    state->greatest = initial_speed;
}

void ds_neutral_start(const ds_neutral *model, ds_neutral_state *state, double initial_speed, double initial_torque,
                      double omega, double weight)
{
    ds_neutral_fill(model, state, initial_speed, initial_torque, omega, weight);
    open_top(model, state);
    open_bit(model, state);
}

void ds_neutral_set_inputs(const ds_neutral *model, ds_neutral_state *state, double omega, double weight,
                           double omega_slope, double weight_slope)
{
    ds_top *const top = &state->top;
    ds_bit *const bit = &state->bit;
    if (omega != top->omega.value || omega_slope != 0.0 || top->omega.slope != 0.0) {
        const ds_ramp drive = {state->present, omega, omega_slope};
        if (top->block == state->present.block && ds_top_cut(top, state->present.fraction)) {
            ds_top_close(&model->top, &model->clock, top, &state->down, ds_neutral_down_ring(state));
        }
        top->omega = drive;
        ds_bit_earn(bit, DS_INPUT_CREDIT);
        open_top(model, state);
    }
    if (weight != bit->wob.value || weight_slope != 0.0 || bit->wob.slope != 0.0) {
        const ds_ramp wob = {state->present, weight, weight_slope};
        if (bit->block == state->present.block && ds_bit_cut(bit, state->present.fraction)) {
            ds_bit_close(&state->law, &model->clock, bit, &state->up, state->ring);
        }
        bit->wob = wob;
        ds_bit_earn(bit, DS_INPUT_CREDIT);
        open_bit(model, state);
    }
}

void ds_neutral_set_friction(const ds_neutral *model, ds_neutral_state *state, const ds_parameters *parameters)
{
    if (state->bit.block == state->present.block && ds_bit_cut(&state->bit, state->present.fraction)) {
        ds_bit_close(&state->law, &model->clock, &state->bit, &state->up, state->ring);
    }
    state->law = ds_neutral_bit_law(parameters, model->impedance);
    ds_bit_earn(&state->bit, DS_INPUT_CREDIT);
    open_bit(model, state);
}

void ds_neutral_widen(ds_neutral_state *state, double x0, double x1)
{
    double low;
    double high;
    ds_bit_extremes(&state->bit, x0, x1, &low, &high);
    if (low < state->least) {
        state->least = low;
    }
    if (high > state->greatest) {
        state->greatest = high;
    }
}

/* finish the piece of the top and take up the next */
static void next_top(const ds_neutral *model, ds_neutral_state *state)
{
    ds_top_close(&model->top, &model->clock, &state->top, &state->down, ds_neutral_down_ring(state));
    open_top(model, state);
}

/* finish the piece of the bit, whose range from x on counts, and take up the next, which counts from 0 */
static double next_bit(const ds_neutral *model, ds_neutral_state *state, double x)
{
    ds_neutral_widen(state, x, 1.0);
    ds_bit_close(&state->law, &model->clock, &state->bit, &state->up, state->ring);
    open_bit(model, state);
    return 0.0;
}

int ds_neutral_advance(const ds_neutral *model, ds_neutral_state *state, double time)
{
    const ds_place goal = ds_clock_place(&model->clock, time);
    ds_top *const top = &state->top;
    ds_bit *const bit = &state->bit;
    if (bit->credit < 0.0) {
        return 0;
    }
    double x = ds_neutral_present_in(state, bit->block, bit->begin, bit->end);
    ds_bit_extremes(bit, x, x, &state->least, &state->greatest);
    while (top->block < goal.block || bit->block < goal.block) {
        /* an input that changes at the end of a block has put one of them ahead */
        const int64_t block = top->block < bit->block ? top->block : bit->block;
        while (top->block == block) {
            next_top(model, state);
        }
        while (bit->block == block) {
            x = next_bit(model, state, x);
            if (bit->credit < 0.0) {
                return 0;
            }
        }
    }
    while (top->end < goal.fraction) {
        next_top(model, state);
    }
    while (bit->end < goal.fraction) {
        x = next_bit(model, state, x);
        if (bit->credit < 0.0) {
            return 0;
        }
    }
    state->present = goal;
    ds_neutral_widen(state, x, ds_neutral_present_in(state, bit->block, bit->begin, bit->end));
    return 1;
}

void ds_neutral_keep(ds_neutral_state *state)
{
    memcpy(ds_neutral_kept(state), state, sizeof *state);
    ds_line_keep(&state->up, state->ring);
    ds_line_keep(&state->down, ds_neutral_down_ring(state));
}

void ds_neutral_put_back(ds_neutral_state *state)
{
    const ds_neutral_state *const before = ds_neutral_kept(state);
    ds_line_put_back(&state->up, state->ring, &before->up);
    ds_line_put_back(&state->down, ds_neutral_down_ring(state), &before->down);
    memcpy(state, before, sizeof *state);
}

void ds_neutral_let_go(ds_neutral_state *state)
{
    state->up.left = 0;
    state->up.kept = 0;
    state->down.left = 0;
    state->down.kept = 0;
}

/* integral of the squared wave of a piece from a fraction of the block to its end, in blocks */
static double square_after(ds_piece piece, double fraction)
{
    const ds_quartic rest = ds_quartic_restrict(piece.wave, (fraction - piece.begin) / (piece.end - piece.begin), 1.0);
    return (piece.end - fraction) * ds_quartic_square_integral(rest);
}

double ds_neutral_energy(const ds_neutral *model, const ds_neutral_state *state, ds_piece from_bit, ds_piece from_top)
{
    const ds_bit *const bit = &state->bit;
    const ds_top *const top = &state->top;
    const double x = ds_neutral_present_in(state, bit->block, bit->begin, bit->end);
    const double y = ds_neutral_present_in(state, top->block, top->begin, top->end);
    const ds_quartic wave = ds_quartic_subtract(bit->turning, bit->incident);
    double up = state->up.square + state->up.square_rest;
    up += square_after(from_bit, top->begin + y * (top->end - top->begin));
    up += (bit->end - bit->begin) * ds_quartic_product_integral(wave, wave, x);
    double down = state->down.square + state->down.square_rest;
    down += square_after(from_top, bit->begin + x * (bit->end - bit->begin));
    down += (top->end - top->begin) * ds_quartic_product_integral(top->outgoing, top->outgoing, y);
    const double speed = ds_quartic_value(bit->turning, x);
    return model->impedance * model->clock.block * (up + down) + 0.5 * model->parameters.I_B * (speed * speed);
}

void ds_neutral_read(const ds_neutral *model, const ds_neutral_state *state, double value[])
{
    const ds_bit *const bit = &state->bit;
    const ds_top *const top = &state->top;
    const double block = model->clock.block;
    const double x = ds_neutral_present_in(state, bit->block, bit->begin, bit->end);
    const double y = ds_neutral_present_in(state, top->block, top->begin, top->end);
    const double bit_piece = (bit->end - bit->begin) * block;
    const double top_piece = (top->end - top->begin) * block;
    const ds_quartic speed = ds_top_speed(top);
    const ds_top_powers powers = ds_top_power_integrals(&model->top, &model->clock, top, y);
    value[DS_bit_speed] = ds_quartic_value(bit->turning, x);
    value[DS_top_speed] = ds_quartic_value(speed, y);
    value[DS_bit_torque] = ds_bit_torque(&state->law, bit, x);
    value[DS_top_torque] = ds_top_torque(&model->top, &model->clock, top, y);
    value[DS_bit_angle] = bit->angle + bit_piece * ds_quartic_integral(bit->turning, x);
    value[DS_top_angle] = top->angle + top_piece * ds_quartic_integral(speed, y);
    value[DS_bit_stuck] = bit->direction == 0;
    value[DS_energy] = ds_neutral_energy(model, state, top->incoming, bit->incoming);
    value[DS_bit_speed_min] = state->least;
    value[DS_bit_speed_max] = state->greatest;
    value[DS_stuck_time] = bit->direction == 0 ? bit->stuck + x * bit_piece : bit->stuck;
    value[DS_slip_count] = bit->slips;
    value[DS_last_stop_time] = bit->last_stop;
    value[DS_last_release_time] = bit->last_release;
    value[DS_work_in] = top->work + top_piece * powers.work;
    value[DS_bit_loss] = bit->loss + bit_piece * ds_bit_power_integral(&state->law, bit, x);
    value[DS_drive_work] = top->driven + top_piece * powers.driven;
    value[DS_top_loss] = top->slid + top_piece * powers.slid;
    value[DS_cells_used] = model->cells;
    value[DS_breaks_folded] = state->up.folded + state->down.folded;
    value[DS_folded_energy] = model->impedance * block * (state->up.folded_square + state->down.folded_square);
}
