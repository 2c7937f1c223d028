/* The drillstring with damping along it, eqs. (1) to (4), and stations on it. Follows models/plant/distributed.py.
 * The memory of its state holds ds_distributed_state and, behind it, the state of the neutral plant it is made from,
 * which ends in an array and so can be no member of a struct. */
#ifndef DS_DISTRIBUTED_H
#define DS_DISTRIBUTED_H

#include <stddef.h>

#include "ds_damped_end.h"
#include "ds_exchange.h"
#include "ds_linkage.h"
#include "ds_neutral.h"
#include "ds_table.h"

typedef struct {
    ds_neutral string; /* the string without damping */
    double beta;       /* N s/rad, damping per unit length, eq. (1) */
    ds_exchange_law exchange;
    int parts;         /* 1, parts into which the stations divide the string */
} ds_distributed;

typedef struct {
    int above;    /* 1, where the up-going block of the station begins in its ring */
    int below;    /* 1, where the down-going one begins */
    double angle; /* rad, angle of the station at the begin of the block */
} ds_station_state;

typedef struct {
    ds_damped_end top_end;
    ds_damped_end bit_end;
    double string_loss;  /* J, lost along the string in the blocks that are finished */
    double last_loss;    /* J, lost there in the last of them */
    ds_station_state station[DS_MOST_stations];
} ds_distributed_state;

typedef struct {
    double speed;  /* rad/s */
    double torque; /* N m */
    double twist;  /* rad, of the string above it */
} ds_station_outputs;

static inline ds_neutral_state *ds_distributed_string(ds_distributed_state *state)
{
    void *const behind = state + 1;
    return behind;
}

static inline const ds_neutral_state *ds_distributed_string_in(const ds_distributed_state *state)
{
    const void *const behind = state + 1;
    return behind;
}

/* fraction of the block of the ends that has passed */
static inline double ds_distributed_elapsed(const ds_neutral_state *string)
{
    return (double)(string->present.block - string->top.block) + string->present.fraction;
}

/* blocks in a travel time: a multiple of the parts, and so many that damping changes a wave little in each */
DS_SHARED int ds_distributed_blocks(const ds_parameters *parameters, double beta, int cells, int stations);
/* cells in a travel time that the damping alone asks for */
DS_SHARED double ds_distributed_damping_cells(const ds_parameters *parameters, double beta);
/* bytes of the state */
DS_SHARED size_t ds_distributed_state_size(int blocks);
DS_SHARED void ds_distributed_build(ds_distributed *model, const ds_parameters *parameters, double beta, int cells,
                                    int stations, double start);
DS_SHARED void ds_distributed_start(const ds_distributed *model, ds_distributed_state *state, double initial_speed,
                                    double initial_torque, double omega, double weight);
DS_SHARED void ds_distributed_set_inputs(const ds_distributed *model, ds_distributed_state *state, double omega,
                                         double weight, double omega_slope, double weight_slope);
DS_SHARED void ds_distributed_set_friction(const ds_distributed *model, ds_distributed_state *state,
                                           const ds_parameters *parameters);
/* go to a time; 0, part of the way, if the credit of the bit is spent */
DS_SHARED int ds_distributed_advance(const ds_distributed *model, ds_distributed_state *state, double time);
/* keep what a step overwrites, and put it back; to let it go is the business of the string: see ds_neutral.h */
DS_SHARED void ds_distributed_keep(ds_distributed_state *state);
DS_SHARED void ds_distributed_put_back(ds_distributed_state *state);
/* write the outputs that the neutral plant has as well */
DS_SHARED void ds_distributed_read(const ds_distributed *model, const ds_distributed_state *state, double value[]);
/* energy lost along the string since the start [J] */
DS_SHARED double ds_distributed_string_loss(const ds_distributed *model, const ds_distributed_state *state);
/* what is read at a station, counted from the top from 0 on; top_angle is that of the outputs */
DS_SHARED ds_station_outputs ds_distributed_station(const ds_distributed *model, const ds_distributed_state *state,
                                                    int number, double top_angle);

#endif
