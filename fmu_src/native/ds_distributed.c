#include "ds_distributed.h"

#include <math.h>
#include <string.h>

#include "ds_station.h"
#include "ds_work.h"

#define MOST_STRENGTH 0.125 /* a wave loses about this share of itself while it crosses a block, at most */

static double exchange_rate(const ds_parameters *parameters, double beta)
{
    return 0.25 * beta / parameters->I;
}

static double damping_blocks(const ds_parameters *p, double beta)
{
    return p->L * sqrt(p->I / (p->G * p->J)) * exchange_rate(p, beta) / MOST_STRENGTH;
}

double ds_distributed_damping_cells(const ds_parameters *parameters, double beta)
{
    return DS_BLOCK * damping_blocks(parameters, beta);
}

int ds_distributed_blocks(const ds_parameters *parameters, double beta, int cells, int stations)
{
    const double ratio = damping_blocks(parameters, beta);
    const int parts = stations + 1;
    int blocks = ds_clock_blocks(cells);
    int damped = (int)ratio;
    if (damped < ratio) {
        damped += 1;
    }
    if (damped > blocks) {
        blocks = damped;
    }
    return (blocks + parts - 1) / parts * parts;
}

size_t ds_distributed_state_size(int blocks)
{
    return sizeof(ds_distributed_state) + ds_neutral_state_size(blocks);
}

void ds_distributed_build(ds_distributed *model, const ds_parameters *parameters, double beta, int cells, int stations,
                          double start)
{
    ds_neutral_build(&model->string, parameters, cells, start);
    ds_neutral_divide(&model->string, ds_distributed_blocks(parameters, beta, model->string.cells, stations));
    model->beta = beta;
    model->string.earning = ds_work_earning(
        beta, parameters->L * sqrt(parameters->I / (parameters->G * parameters->J)), model->string.blocks);
    model->exchange = ds_exchange_of(exchange_rate(parameters, beta) * model->string.clock.block);
    model->parts = stations + 1;
}

/* the pieces of both ends */
static ds_end_piece top_piece(const ds_top *top)
{
    const ds_end_piece piece = {top->begin, top->end, top->incident, top->outgoing, ds_top_speed(top)};
    return piece;
}

static ds_end_piece bit_piece(const ds_bit *bit)
{
    const ds_end_piece piece = {bit->begin, bit->end, bit->incident, ds_quartic_subtract(bit->turning, bit->incident),
                                bit->turning};
    return piece;
}

static void open_damped_top(const ds_distributed *model, ds_distributed_state *state)
{
    const ds_neutral *const m = &model->string;
    ds_neutral_state *const s = ds_distributed_string(state);
    ds_top *const top = &s->top;
    if (model->beta > 0.0) {
        if (top->begin >= top->incoming.end) {
            ds_damped_end_take(&state->top_end, &s->up, s->ring);
        }
        double rise;
        const double omega =
            ds_ramp_at(&top->omega, &m->clock, top->block, top->begin, state->top_end.raw.end, &rise);
        const ds_sending sending = {-m->top.reflection, m->top.transmission * omega, m->top.transmission * rise};
        top->incoming = ds_damped_end_incident(&state->top_end, model->exchange.strength, top->begin, sending);
    }
    ds_top_open(&m->top, &m->clock, top, &s->up, s->ring);
}

static void close_damped_top(const ds_distributed *model, ds_distributed_state *state)
{
    const ds_neutral *const m = &model->string;
    ds_neutral_state *const s = ds_distributed_string(state);
    ds_top *const top = &s->top;
    if (!(model->beta > 0.0)) {
        ds_top_close(&m->top, &m->clock, top, &s->down, ds_neutral_down_ring(s));
        return;
    }
    const ds_end_piece closed = top_piece(top);
    const ds_piece piece = {top->begin, top->end,
                            ds_damped_end_outgoing(&state->top_end, model->exchange.strength, &closed), 0.0};
    ds_line_push(&s->down, ds_neutral_down_ring(s), piece);
    ds_top_finish(&m->top, &m->clock, top);
}

/* about how much the bit speed rises up to the end of the piece, as far as its begin tells */
static double coming_rise(const ds_distributed *model, const ds_distributed_state *state, double end)
{
    const ds_neutral_state *const s = ds_distributed_string_in(state);
    const ds_clock *const clock = &model->string.clock;
    const ds_bit *const bit = &s->bit;
    const ds_bit_law *const law = &s->law;
    const double duration = (end - bit->begin) * clock->block;
    double rise;
    const double weight = ds_ramp_at(&bit->wob, clock, bit->block, bit->begin, end, &rise);
    const double torque = law->twice_impedance * ds_damped_end_wave(&state->bit_end, bit->begin);
    if (bit->speed == 0.0) {
        const double holding = law->friction.static_ * weight;
        if (fabs(torque) <= holding) {
            return 0.0;
        }
        return duration * (torque > 0.0 ? torque - holding : torque + holding) / law->inertia;
    }
    const int direction = bit->speed > 0.0 ? 1 : -1;
    const double dry = ds_friction_at(&law->friction, weight, direction * bit->speed).torque * direction;
    return duration * (torque - law->damping * bit->speed - dry) / law->inertia;
}

static void open_damped_bit(const ds_distributed *model, ds_distributed_state *state)
{
    ds_neutral_state *const s = ds_distributed_string(state);
    ds_piece *const down_ring = ds_neutral_down_ring(s);
    ds_bit *const bit = &s->bit;
    if (model->beta > 0.0) {
        if (bit->begin >= bit->incoming.end) {
            ds_damped_end_take(&state->bit_end, &s->down, down_ring);
        }
        const ds_sending sending = {-1.0, bit->speed, coming_rise(model, state, state->bit_end.raw.end)};
        bit->incoming = ds_damped_end_incident(&state->bit_end, model->exchange.strength, bit->begin, sending);
    }
    ds_bit_open(&s->law, &model->string.clock, bit, &s->down, down_ring);
}

static void close_damped_bit(const ds_distributed *model, ds_distributed_state *state)
{
    ds_neutral_state *const s = ds_distributed_string(state);
    ds_bit *const bit = &s->bit;
    if (!(model->beta > 0.0)) {
        ds_bit_close(&s->law, &model->string.clock, bit, &s->up, s->ring);
        return;
    }
    const ds_end_piece closed = bit_piece(bit);
    const ds_piece piece = {bit->begin, bit->end,
                            ds_damped_end_outgoing(&state->bit_end, model->exchange.strength, &closed), 0.0};
    ds_line_push(&s->up, s->ring, piece);
    ds_bit_finish(&s->law, &model->string.clock, bit);
}

/* find where the blocks begin that cross at the stations at the start */
static void find_stations(const ds_distributed *model, ds_distributed_state *state)
{
    ds_neutral_state *const s = ds_distributed_string(state);
    const ds_piece *const down_ring = ds_neutral_down_ring(s);
    const int distance = model->string.blocks / model->parts;
    int above = s->up.first;
    int below = ds_exchange_forth(&s->down, down_ring, ds_exchange_newest(&s->down, down_ring));
    for (int number = 0; number + 1 < model->parts; ++number) {
        for (int i = 0; i < distance; ++i) {
            above = ds_exchange_forth(&s->up, s->ring, above);
            below = ds_exchange_back(&s->down, down_ring, below);
        }
        state->station[number].above = above;
        state->station[number].below = below;
    }
}

/* move on to the blocks that cross at the stations next, when the lines have moved by a block */
static void move_stations(const ds_distributed *model, ds_distributed_state *state)
{
    ds_neutral_state *const s = ds_distributed_string(state);
    for (int number = 0; number + 1 < model->parts; ++number) {
        ds_station_state *const station = &state->station[number];
        station->above = ds_exchange_forth(&s->up, s->ring, station->above);
        station->below = ds_exchange_forth(&s->down, ds_neutral_down_ring(s), station->below);
    }
}

static ds_station_reading read_station(const ds_distributed *model, const ds_distributed_state *state, int number,
                                       double fraction)
{
    const ds_neutral_state *const s = ds_distributed_string_in(state);
    const ds_station_state *const station = &state->station[number];
    return ds_station_read(&s->up, s->ring, station->above, &s->down, s->ring + s->up.capacity, station->below,
                           fraction, model->exchange.strength);
}

/* fill the lines with uniform rotation, each wave as it is before it crosses what it meets next */
static void fill_damped(const ds_distributed *model, ds_distributed_state *state, double initial_speed,
                        double initial_torque)
{
    ds_neutral_state *const s = ds_distributed_string(state);
    ds_piece *const down_ring = ds_neutral_down_ring(s);
    const int blocks = model->string.blocks;
    const double twice = 2.0 * model->string.impedance;
    const double drag = model->beta * initial_speed * model->string.parameters.L; /* N m, lost along the string */
    const double slope = 0.5 * (drag / blocks) / twice;
    s->up.square = 0.0;
    s->down.square = 0.0;
    for (int i = 0; i < blocks; ++i) {
        const double part = (double)i / blocks;
        const double up = initial_torque + drag * (1.0 - part);
        const double down = initial_torque + drag * part;
        const ds_quartic rising = {0.5 * initial_speed - up / twice, slope, 0.0, 0.0, 0.0};
        const ds_quartic falling = {0.5 * initial_speed + down / twice, slope, 0.0, 0.0, 0.0};
        s->ring[i].wave = rising;
        s->ring[i].square = ds_quartic_square_integral(rising);
        down_ring[i].wave = falling;
        down_ring[i].square = ds_quartic_square_integral(falling);
        s->up.square = s->up.square + s->ring[i].square;
        s->down.square = s->down.square + down_ring[i].square;
    }
    state->last_loss = drag * initial_speed * model->string.clock.block * (1.0 - 0.5 / blocks);
    state->string_loss = 0.25 * state->last_loss;
}

void ds_distributed_start(const ds_distributed *model, ds_distributed_state *state, double initial_speed,
                          double initial_torque, double omega, double weight)
{
    const ds_parameters *const p = &model->string.parameters;
    ds_neutral_state *const s = ds_distributed_string(state);
    const double stiffness = p->G * p->J / p->L;
    const double drag = model->beta * initial_speed * p->L;
    ds_neutral_fill(&model->string, s, initial_speed, initial_torque, omega, weight);
    s->top.angle = (initial_torque + 0.5 * drag) / stiffness;
    ds_damped_end_start(&state->top_end);
    ds_damped_end_start(&state->bit_end);
    state->string_loss = 0.0;
    state->last_loss = 0.0;
    for (int i = 0; i < DS_MOST_stations; ++i) {
        const double below = 1.0 - (double)(i + 1) / model->parts;
        const ds_station_state station = {0, 0, below * (initial_torque + 0.5 * (drag * below)) / stiffness};
        state->station[i] = station;
    }
    if (model->beta > 0.0) {
        fill_damped(model, state, initial_speed, initial_torque);
    }
    find_stations(model, state);
    open_damped_top(model, state);
    open_damped_bit(model, state);
}

/* finish the pieces of the bit up to the end of the block, the range from x of the first on counting; 0 if its credit
 * is spent */
static int finish_bit(const ds_distributed *model, ds_distributed_state *state, double x)
{
    ds_neutral_state *const s = ds_distributed_string(state);
    const int64_t block = s->bit.block;
    ds_neutral_widen(s, x, 1.0);
    close_damped_bit(model, state);
    while (s->bit.block == block) {
        open_damped_bit(model, state);
        if (s->bit.credit < 0.0) {
            return 0;
        }
        ds_neutral_widen(s, 0.0, 1.0);
        close_damped_bit(model, state);
    }
    return 1;
}

/* go to the end of the block, and let the waves cross; the range of the bit from x of its piece on counts; 0 if its
 * credit is spent */
static int finish_block(const ds_distributed *model, ds_distributed_state *state, double x)
{
    ds_neutral_state *const s = ds_distributed_string(state);
    const ds_neutral *const m = &model->string;
    const int64_t block = s->top.block;
    close_damped_top(model, state);
    while (s->top.block == block) {
        open_damped_top(model, state);
        close_damped_top(model, state);
    }
    if (!finish_bit(model, state, x)) {
        return 0;
    }
    for (int i = 0; i + 1 < model->parts; ++i) {
        ds_station_state *const station = &state->station[i];
        station->angle = station->angle + m->clock.block * read_station(model, state, i, 1.0).turned;
    }
    if (model->beta > 0.0) {
        const ds_neutral_state *const before = ds_neutral_kept(s);
        ds_line_keep_all(&s->up, s->ring, &before->up);
        ds_line_keep_all(&s->down, ds_neutral_down_ring(s), &before->down);
        state->last_loss = m->impedance * m->clock.block *
                           ds_exchange_all(&s->up, s->ring, &s->down, ds_neutral_down_ring(s), &model->exchange);
        state->string_loss = state->string_loss + state->last_loss;
    }
    move_stations(model, state);
    return 1;
}

/* if the present is at the end of the block, finish it; say so, as then both ends have to be opened */
static int turn_at_present(const ds_distributed *model, ds_distributed_state *state)
{
    const ds_neutral_state *const s = ds_distributed_string(state);
    if (1.0 - s->present.fraction > DS_SNAP || s->top.block != s->present.block) {
        return 0;
    }
    return finish_block(model, state, 1.0);
}

void ds_distributed_set_inputs(const ds_distributed *model, ds_distributed_state *state, double omega, double weight,
                               double omega_slope, double weight_slope)
{
    ds_neutral_state *const s = ds_distributed_string(state);
    const int drive = omega != s->top.omega.value || omega_slope != 0.0 || s->top.omega.slope != 0.0;
    const int wob_changes = weight != s->bit.wob.value || weight_slope != 0.0 || s->bit.wob.slope != 0.0;
    if (!drive && !wob_changes) {
        return;
    }
    const int turned = turn_at_present(model, state);
    if (s->bit.credit < 0.0) {
        return;
    }
    if (drive) {
        const ds_ramp ramp = {s->present, omega, omega_slope};
        if (s->top.block == s->present.block && ds_top_cut(&s->top, s->present.fraction)) {
            close_damped_top(model, state);
        }
        s->top.omega = ramp;
        ds_bit_earn(&s->bit, DS_INPUT_CREDIT);
    }
    if (wob_changes) {
        const ds_ramp ramp = {s->present, weight, weight_slope};
        if (s->bit.block == s->present.block && ds_bit_cut(&s->bit, s->present.fraction)) {
            close_damped_bit(model, state);
        }
        s->bit.wob = ramp;
        ds_bit_earn(&s->bit, DS_INPUT_CREDIT);
    }
    if (drive || turned) {
        open_damped_top(model, state);
    }
    if (wob_changes || turned) {
        open_damped_bit(model, state);
    }
}

void ds_distributed_set_friction(const ds_distributed *model, ds_distributed_state *state,
                                 const ds_parameters *parameters)
{
    ds_neutral_state *const s = ds_distributed_string(state);
    const int turned = turn_at_present(model, state);
    if (s->bit.credit < 0.0) {
        return;
    }
    if (s->bit.block == s->present.block && ds_bit_cut(&s->bit, s->present.fraction)) {
        close_damped_bit(model, state);
    }
    s->law = ds_neutral_bit_law(parameters, model->string.impedance);
    ds_bit_earn(&s->bit, DS_INPUT_CREDIT);
    if (turned) {
        open_damped_top(model, state);
    }
    open_damped_bit(model, state);
}

int ds_distributed_advance(const ds_distributed *model, ds_distributed_state *state, double time)
{
    const ds_place goal = ds_clock_place(&model->string.clock, time);
    ds_neutral_state *const s = ds_distributed_string(state);
    ds_bit *const bit = &s->bit;
    if (bit->credit < 0.0) {
        return 0;
    }
    double x = ds_neutral_present_in(s, bit->block, bit->begin, bit->end);
    ds_bit_extremes(bit, x, x, &s->least, &s->greatest);
    while (s->top.block < goal.block) {
        if (!finish_block(model, state, x)) {
            return 0;
        }
        open_damped_top(model, state);
        open_damped_bit(model, state);
        if (bit->credit < 0.0) {
            return 0;
        }
        x = 0.0;
    }
    while (s->top.end < goal.fraction) {
        close_damped_top(model, state);
        open_damped_top(model, state);
    }
    while (bit->end < goal.fraction) {
        ds_neutral_widen(s, x, 1.0);
        close_damped_bit(model, state);
        open_damped_bit(model, state);
        if (bit->credit < 0.0) {
            return 0;
        }
        x = 0.0;
    }
    s->present = goal;
    ds_neutral_widen(s, x, ds_neutral_present_in(s, bit->block, bit->begin, bit->end));
    return 1;
}

void ds_distributed_keep(ds_distributed_state *state)
{
    ds_neutral_state *const s = ds_distributed_string(state);
    memcpy(ds_neutral_kept(s)->ring, state, sizeof *state);
    ds_neutral_keep(s);
}

void ds_distributed_put_back(ds_distributed_state *state)
{
    ds_neutral_state *const s = ds_distributed_string(state);
    memcpy(state, ds_neutral_kept(s)->ring, sizeof *state);
    ds_neutral_put_back(s);
}

/* what the cells have taken from the waves before its time: a cell takes it at once, between blocks; the part of the
 * cells that the present has already passed grows steadily, by one row of cells a block */
static double still_stored(const ds_distributed_state *state)
{
    return state->last_loss * (0.25 - ds_distributed_elapsed(ds_distributed_string_in(state)));
}

/* what the pieces at both ends have settled up to the present [rad2/s2 blocks] */
static double settled(const ds_distributed *model, const ds_distributed_state *state)
{
    const ds_neutral_state *const s = ds_distributed_string_in(state);
    const ds_end_piece top = top_piece(&s->top);
    const ds_end_piece bit = bit_piece(&s->bit);
    const double x = ds_neutral_present_in(s, s->bit.block, bit.begin, bit.end);
    const double y = ds_neutral_present_in(s, s->top.block, top.begin, top.end);
    const double at_top = ds_damped_end_settled(&state->top_end, model->exchange.strength, &top, y);
    return at_top + ds_damped_end_settled(&state->bit_end, model->exchange.strength, &bit, x);
}

void ds_distributed_read(const ds_distributed *model, const ds_distributed_state *state, double value[])
{
    const ds_neutral_state *const s = ds_distributed_string_in(state);
    ds_neutral_read(&model->string, s, value);
    if (model->beta > 0.0) {
        value[DS_energy] = ds_neutral_energy(&model->string, s, state->top_end.raw, state->bit_end.raw);
        value[DS_energy] = value[DS_energy] + model->string.impedance * model->string.clock.block * settled(model, state);
    }
    value[DS_energy] = value[DS_energy] + still_stored(state);
}

double ds_distributed_string_loss(const ds_distributed *model, const ds_distributed_state *state)
{
    const ds_neutral *const m = &model->string;
    const ds_neutral_state *const s = ds_distributed_string_in(state);
    const ds_end_piece top = top_piece(&s->top);
    const ds_end_piece bit = bit_piece(&s->bit);
    const double x = ds_neutral_present_in(s, s->bit.block, bit.begin, bit.end);
    const double y = ds_neutral_present_in(s, s->top.block, top.begin, top.end);
    const double ends =
        ds_damped_end_square(&state->top_end, &top, y) + ds_damped_end_square(&state->bit_end, &bit, x);
    const double at_ends = model->exchange.strength * m->impedance * m->clock.block * ends;
    return (state->string_loss + at_ends) - still_stored(state);
}

ds_station_outputs ds_distributed_station(const ds_distributed *model, const ds_distributed_state *state, int number,
                                          double top_angle)
{
    const ds_neutral_state *const s = ds_distributed_string_in(state);
    const ds_station_reading r = read_station(model, state, number, ds_distributed_elapsed(s));
    const double angle = state->station[number].angle + model->string.clock.block * r.turned;
    const ds_station_outputs outputs = {r.up + r.down, model->string.impedance * (r.down - r.up), top_angle - angle};
    return outputs;
}
