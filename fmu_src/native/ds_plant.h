/* What the FMUs of the plants have in common: values by value reference to and from the core. Both tables have all the
 * variables named here. */
#ifndef DS_PLANT_H
#define DS_PLANT_H

#include "ds_linkage.h"
#include "ds_model.h"
#include "ds_neutral.h"
#include "ds_neutral_rate.h"

/* what the events of a step are told from, as it was before the step */
typedef struct {
    double slip_count, last_stop_time, breaks_folded;
} ds_plant_history;

/* damping along the string times the initial speed: how much the torque in it grows from the bit to the top */
typedef struct {
    double torque; /* N m */
    double change; /* N m, its derivative in the direction asked for */
} ds_plant_drag;

DS_SHARED ds_parameters ds_plant_parameters(const double value[]);
/* cells in one travel time, 0 with a reason if there are too many */
DS_SHARED int ds_plant_cells(const double value[], ds_journal *journal);
/* whether a string in so many blocks takes no more work than is allowed; says what to set if it does */
DS_SHARED int ds_plant_affords(const ds_parameters *parameters, double beta, int blocks, int cells,
                               ds_journal *journal);
/* say that the bit moves too fast to be followed at the cost that is allowed */
DS_SHARED void ds_plant_spent(const ds_clock *clock, const ds_bit *bit, ds_journal *journal);
/* whether blocks can be counted as far as the end of a step; says so if not */
DS_SHARED int ds_plant_reaches(const ds_clock *clock, double end, ds_journal *journal);
/* whether the tunable friction has changed */
DS_SHARED int ds_plant_tuned(const ds_parameters *old, const ds_parameters *parameters);
DS_SHARED ds_plant_history ds_plant_before(const double value[]);
/* say that the bit has stopped or broken loose since `before`, in the order of time; of several stops, the last */
DS_SHARED void ds_plant_tell(const double value[], const ds_plant_history *before, double end, ds_journal *journal);
/* how much the outputs change at once with the inputs */
DS_SHARED void ds_plant_differentiate(const ds_top_law *top, const ds_neutral_state *state, const double seed[],
                                      double change[]);
/* how much the outputs at the start change with all they are made from: see model 8 for what is before it */
DS_SHARED void ds_plant_differentiate_start(double impedance, int direction, ds_plant_drag drag, const double value[],
                                            const double seed[], double change[]);

#endif
