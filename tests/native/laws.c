#include "laws.h"

#include <math.h>

#include "plant.h"

#define BALANCE_ERROR 2e-9          /* 1, share of the greatest energy seen that may be missing inside a piece */
#define GREATEST_BALANCE_ERROR 1e-3 /* 1, the same on the coarsest grid */
#define DAMPING_ERROR 4.0           /* 1, the same with damping along the string, of the square of what a crossing takes */
#define LEAST_ENERGY 1e3            /* J, what a bit at 5 rad/s holds: less is not what the share is taken of */
#define CANCELLING 1e-15            /* 1, share of its terms that a difference may be off by */
#define SNAP 1e-11                  /* 1, share of a travel time by which an input change may be moved: ds_clock.h */
#define LONGEST_CELL 0.0005         /* s, on coarser grids the plant's errors grow as the sixth power */

#define LAW(s, condition, ...) \
    do { \
        if (!(condition)) { \
            subject_describe(s); \
            session_fail((s)->run, __VA_ARGS__); \
        } \
    } while (0)

static void numbers_are_finite(const subject *s)
{
    for (int i = 0; i < DS_VARIABLES; ++i) {
        LAW(s, isfinite(s->known.value[i]), "%s is %g", ds_variables[i].name, s->known.value[i]);
    }
}

/* share of the energy that may be missing with the cells the plant was given */
static double balance_error(const subject *s)
{
    const double cell = plant_travel_time(s) / subject_value(s, "cells_used");
    const double coarseness = fmax(1.0, cell / LONGEST_CELL);
    const double crossing = plant_crossing_loss(s);
    return fmin(BALANCE_ERROR * pow(coarseness, 6.0), GREATEST_BALANCE_ERROR) + DAMPING_ERROR * crossing * crossing;
}

/* J, what c_a (Omega - top_speed) may lose of the work since the last communication point where the two cancel */
static double lost_in_cancelling(const subject *s, double since)
{
    const double fastest = fmax(fabs(subject_value(s, "Omega")), fabs(subject_value(s, "top_speed")));
    return CANCELLING * subject_value(s, "c_a") * fastest * fastest * (s->known.time - since);
}

static void energy_is_accounted_for(subject *s, const knowledge *before)
{
    knowledge *const known = &s->known;
    const double energy = subject_value(s, "energy");
    const double put_in = subject_value(s, "work_in");
    const double lost = subject_value(s, "bit_loss") + plant_string_loss(s);
    const double folded = subject_value(s, "folded_energy");
    if (before == NULL) {
        known->energy = energy;
        known->greatest = 0.0;
        known->rounding = 0.0;
    } else {
        known->rounding += lost_in_cancelling(s, before->time);
    }
    known->greatest = fmax(known->greatest, fmax(fabs(energy), fmax(fabs(put_in), fmax(fabs(lost), fabs(folded)))));
    const double missing = energy - (known->energy + put_in - lost - folded);
    LAW(s, fabs(missing) <= balance_error(s) * (known->greatest + LEAST_ENERGY) + known->rounding,
        "of %.17g J at the most, %.3g J are unaccounted for: energy %.17g, at the start %.17g, work_in %.17g, "
        "lost %.17g, folded_energy %.17g",
        known->greatest, missing, energy, known->energy, put_in, lost, folded);
}

static void friction_holds_or_drags(const subject *s)
{
    const double limit = subject_value(s, "WOB") * subject_value(s, "R_b") * subject_value(s, "mu_sb");
    const double torque = fabs(subject_value(s, "bit_torque"));
    if (subject_value(s, "bit_stuck") == 0.0) {
        return;
    }
    LAW(s, subject_value(s, "bit_speed") == 0.0, "a stuck bit turns at %g rad/s", subject_value(s, "bit_speed"));
    LAW(s, s->known.ramped || s->known.unread || torque <= limit * (1.0 + 1e-6) + 1e-6,
        "a stuck bit is held with %.17g N.m, static friction is %.17g N.m", torque, limit);
}

static void range_holds_the_speed(const subject *s)
{
    const double least = subject_value(s, "bit_speed_min");
    const double speed = subject_value(s, "bit_speed");
    const double greatest = subject_value(s, "bit_speed_max");
    const double rounding = 1e-9 * (1.0 + fmax(fabs(least), fabs(greatest)));
    LAW(s, least - rounding <= speed && speed <= greatest + rounding,
        "bit_speed is %.17g, its range since the last communication point [%.17g, %.17g]", speed, least, greatest);
}

static void counts_never_fall(const subject *s, const knowledge *before)
{
    static const char *const COUNTS[] = {"stuck_time",        "slip_count",    "last_stop_time",
                                         "last_release_time", "breaks_folded"};
    const double elapsed = s->known.time - s->known.start;
    const double rounding = 1e-9 * (1.0 + fabs(s->known.time));
    const double moved = SNAP * plant_travel_time(s);
    for (size_t i = 0; before != NULL && i < sizeof COUNTS / sizeof *COUNTS; ++i) {
        const int number = variable_named(COUNTS[i]);
        LAW(s, s->known.value[number] >= before->value[number] - moved, "%s falls from %.17g to %.17g", COUNTS[i],
            before->value[number], s->known.value[number]);
    }
    LAW(s, subject_value(s, "stuck_time") <= elapsed + rounding, "stuck for %.17g s of %.17g s",
        subject_value(s, "stuck_time"), elapsed);
    LAW(s,
        subject_value(s, "last_stop_time") <= s->known.time + rounding &&
            subject_value(s, "last_release_time") <= s->known.time + rounding,
        "a stop or release lies in the future");
}

static void drive_keeps_its_limit(const subject *s)
{
    const double omega = fabs(subject_value(s, "Omega"));
    const double limit = subject_value(s, "Omega_max");
    LAW(s, s->known.unread || omega <= limit, "Omega is %.17g, its limit %.17g", omega, limit);
    LAW(s, s->known.unread || subject_value(s, "limit_active") == 0.0 || omega == limit,
        "limit_active with Omega %.17g inside its limit %.17g", omega, limit);
}

static void weight_keeps_its_limit(const subject *s)
{
    const double weight = subject_value(s, "WOB");
    const double limit = subject_value(s, "WOB_max");
    LAW(s, weight > 0.0 && (s->known.unread || weight <= limit), "WOB is %.17g, its limit %.17g", weight,
        limit);
}

void laws_hold(subject *s, const knowledge *before)
{
    numbers_are_finite(s);
    if (is_plant()) {
        energy_is_accounted_for(s, before);
        friction_holds_or_drags(s);
        range_holds_the_speed(s);
        counts_never_fall(s, before);
    } else if (variable_named("Omega_max") >= 0) {
        drive_keeps_its_limit(s);
    } else if (variable_named("K_w") >= 0) {
        weight_keeps_its_limit(s);
    }
}
