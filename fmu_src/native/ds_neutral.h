/* The drillstring as a neutral delay system, eqs. (14) and (15), in the form of waves it is computed in.
 * Follows models/plant/neutral.py. The model is constant after the start; the state is one flat block without pointers,
 * so that saving and restoring it is a copy. */
#ifndef DS_NEUTRAL_H
#define DS_NEUTRAL_H

#include <stddef.h>

#include "ds_bit.h"
#include "ds_clock.h"
#include "ds_line.h"
#include "ds_linkage.h"
#include "ds_top.h"

typedef struct {
    double G;     /* Pa, shear modulus, eq. (1) */
    double J;     /* m4, geometrical moment of inertia, eq. (1) */
    double I;     /* kg m, moment of inertia per unit length, eq. (1) */
    double L;     /* m, length */
    double I_B;   /* kg m2, inertia of the bottom hole assembly, eq. (2) */
    double c_a;   /* N m s/rad, damping of the sliding top, eq. (2) */
    ds_friction_parameters friction;
} ds_parameters;

typedef struct {
    ds_parameters parameters;
    ds_top_law top;
    ds_clock clock;
    double impedance; /* N m s/rad, Z */
    int cells;        /* 1, cells in one travel time */
    int blocks;       /* 1, blocks in one travel time */
    double earning;   /* 1/s, work a second that following the bit may take */
} ds_neutral;

typedef struct {
    ds_bit_law law; /* holds the tunable friction */
    ds_top top;
    ds_bit bit;
    ds_place present;
    double least;     /* rad/s, least bit speed since the last communication point */
    double greatest;  /* rad/s, greatest */
    ds_line up;       /* the up-going wave; its ring comes first in `ring` */
    ds_line down;     /* the down-going wave */
    ds_piece ring[];
} ds_neutral_state;

static inline ds_piece *ds_neutral_down_ring(ds_neutral_state *state)
{
    return state->ring + state->up.capacity;
}

/* behind both rings and what the lines keep of them is the state, without rings, as it was when the step began; and
 * behind it, where the ring of that would be, room for what else is kept */
static inline ds_neutral_state *ds_neutral_kept(ds_neutral_state *state)
{
    void *const behind = state->ring + 4 * (ptrdiff_t)state->up.capacity;
    return behind;
}

/* where in the piece that begins and ends at fractions of a block the present lies */
static inline double ds_neutral_present_in(const ds_neutral_state *state, int64_t block, double begin, double end)
{
    if (block != state->present.block || state->present.fraction <= begin) {
        return 0.0;
    }
    return (state->present.fraction - begin) / (end - begin);
}

/* cells in one travel time: as requested, at least 4; for 0 one that keeps a cell at most 0.5 ms */
DS_SHARED int ds_neutral_cells(const ds_parameters *parameters, int requested);
/* bytes of the state with so many blocks in one travel time */
DS_SHARED size_t ds_neutral_state_size(int blocks);
DS_SHARED void ds_neutral_build(ds_neutral *model, const ds_parameters *parameters, int cells, double start);
/* change the number of blocks in one travel time */
DS_SHARED void ds_neutral_divide(ds_neutral *model, int blocks);
DS_SHARED ds_bit_law ds_neutral_bit_law(const ds_parameters *parameters, double impedance);
/* what is before the start */
DS_SHARED void ds_neutral_fill(const ds_neutral *model, ds_neutral_state *state, double initial_speed,
                               double initial_torque, double omega, double weight);
/* fill, and take up the first pieces */
DS_SHARED void ds_neutral_start(const ds_neutral *model, ds_neutral_state *state, double initial_speed,
                                double initial_torque, double omega, double weight);
DS_SHARED void ds_neutral_set_inputs(const ds_neutral *model, ds_neutral_state *state, double omega, double weight,
                                     double omega_slope, double weight_slope);
DS_SHARED void ds_neutral_set_friction(const ds_neutral *model, ds_neutral_state *state,
                                       const ds_parameters *parameters);
/* let the range of bit speeds cover [x0, x1] of the piece */
DS_SHARED void ds_neutral_widen(ds_neutral_state *state, double x0, double x1);
/* go to a time; 0, part of the way, if the credit of the bit is spent */
DS_SHARED int ds_neutral_advance(const ds_neutral *model, ds_neutral_state *state, double time);
/* From `keep` on what is overwritten is kept, in as many bytes behind the state as it has itself, until it is put back
 * or let go. */
DS_SHARED void ds_neutral_keep(ds_neutral_state *state);
DS_SHARED void ds_neutral_put_back(ds_neutral_state *state);
DS_SHARED void ds_neutral_let_go(ds_neutral_state *state);
/* energy stored in the string and the bit, (I L / 2) E of eq. (7), with the incident pieces at the top and at the bit */
DS_SHARED double ds_neutral_energy(const ds_neutral *model, const ds_neutral_state *state, ds_piece from_bit,
                                   ds_piece from_top);
/* write the outputs of a plant to its values */
DS_SHARED void ds_neutral_read(const ds_neutral *model, const ds_neutral_state *state, double value[]);

#endif
