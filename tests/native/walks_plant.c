/* What a drillstring may be driven to. */
#include <math.h>
#include <string.h>

#include "plant.h"
#include "walking.h"
#include "walks.h"

static void stick_slip(session *run, subject *s)
{
    static const setting NOMINAL[] = {{NULL, 0.0}};
    start(s, run, NOMINAL, 0.0);
    go_on(s, 20.0);
    REQUIRE(run, subject_value(s, "slip_count") >= 5.0, "the bit slips %g times only", subject_value(s, "slip_count"));
    finish(s);
}

/* jumps of every input and every tunable parameter */
static void jumps(session *run, subject *s)
{
    static const setting SETTINGS[] = {
        {"cells", 301.0}, {"initial_speed", 6.0}, {"initial_torque", 7500.0}, {NULL, 0.0}};
    static const setting TUNABLE[] = {
        {"mu_sb", 0.8}, {"c_b", 0.3}, {"gamma_b", 0.9}, {"mu_cb", 0.55}, {"gamma_b", 0.7}};
    start(s, run, SETTINGS, 1000.0);
    for (int i = 0; i < 200; ++i) {
        put(s, "Omega", 10.0 + 0.37 * (i * 7 % 11));
        put(s, "WOB", 9.1e4 + 1234.5 * (i * 5 % 7));
        put(s, TUNABLE[i % 5].name, TUNABLE[i % 5].value * (1.0 - 0.01 * (i % 9)));
        go(s, STEP_SIZE[i % STEP_SIZES]);
    }
    finish(s);
}

static void ramps(session *run, subject *s)
{
    static const setting SETTINGS[] = {{"Omega", 0.0}, {"WOB", 2e4}, {NULL, 0.0}};
    start(s, run, SETTINGS, 0.0);
    for (int i = 0; i < 150; ++i) {
        const double size = STEP_SIZE[i % STEP_SIZES];
        put(s, "Omega", fmin(0.8 * s->known.time, 14.0));
        ramp(s, "Omega", s->known.time < 17.0 ? 0.8 : 0.0);
        ramp(s, "WOB", i % 3 == 0 ? 500.0 : -200.0);
        go(s, size);
    }
    finish(s);
}

/* the bit driven backwards, stopped, lifted off, and driven forwards */
static void reverse(session *run, subject *s)
{
    static const setting SETTINGS[] = {
        {"Omega", -10.0}, {"initial_speed", -8.0}, {"initial_torque", -6000.0}, {NULL, 0.0}};
    start(s, run, SETTINGS, -3.0);
    go_on(s, 12.0);
    REQUIRE(run, subject_value(s, "bit_angle") < 0.0, "the bit has not turned backwards");
    put(s, "Omega", 0.0);
    go_on(s, 5.0);
    put(s, "WOB", 0.0);
    go_on(s, 5.0);
    put(s, "WOB", 97347.0);
    put(s, "Omega", 10.0);
    go_on(s, 12.0);
    finish(s);
}

/* a drive that jumps so often that breaks must be folded */
static void chatter(session *run, subject *s)
{
    static const setting SETTINGS[] = {{"cells", 40.0}, {NULL, 0.0}};
    start(s, run, SETTINGS, 0.0);
    for (int i = 0; i < 3000; ++i) {
        put(s, "Omega", i % 2 == 0 ? 25.0 : -5.0 + 0.001 * i);
        put(s, "WOB", 9e4 + (i * 7919 % 101) * 100.0);
        go(s, 0.00037);
    }
    REQUIRE(run, subject_value(s, "breaks_folded") > 0.0, "no break is folded");
    finish(s);
}

/* jumps so large and so many in a travel time that the queue is full of what is not negligible */
static void overflow(session *run, subject *s)
{
    static const setting SETTINGS[] = {{"cells", 1600.0}, {NULL, 0.0}};
    start(s, run, SETTINGS, 0.0);
    const double size = plant_travel_time(s) / 4000.0;
    for (int i = 0; i < 6000; ++i) {
        put(s, "Omega", i % 2 == 0 ? 5e3 : -5e3);
        go(s, size);
    }
    REQUIRE(run, subject_value(s, "breaks_folded") > 0.0, "no break is folded");
    finish(s);
}

/* starts and steps that are refused: for more cells than can be, for a parameter that contradicts another, for inputs
 * that are led out of their range, for an end out of reach */
static void refusals(session *run, subject *s)
{
    const fmi2ValueReference speed = (fmi2ValueReference)variable_named("bit_speed");
    const fmi2ValueReference drive = (fmi2ValueReference)variable_named("Omega");
    const double seed = 1.0;
    subject_instantiate(s, run, "refusing", SOUND, 1);
    put(s, "L", 1e5);
    put(s, "G", 1e6);
    subject_set_up(s, 0.0, 0, 0.0);
    subject_enter(s);
    REQUIRE(run, !subject_exit(s), "a start with more cells than can be is taken");
    put(s, "cells", 40.0);
    put(s, "mu_cb", 0.9);
    subject_get_sensitivities(s, &speed, 1, &drive, 1, &seed, 0);
    REQUIRE(run, !subject_exit(s), "a start with mu_cb above mu_sb is taken");
    put(s, "mu_cb", 0.5);
    REQUIRE(run, subject_exit(s), "a start is refused");
    go(s, 0.01);
    put(s, "mu_cb", 0.9);
    REQUIRE(run, !subject_step(s, s->known.time, 0.01), "a step with mu_cb above mu_sb is taken");
    put(s, "mu_cb", 0.4);
    ramp(s, "Omega", 1e7);
    REQUIRE(run, !subject_step(s, s->known.time, 0.01), "a step to a drive speed out of range is taken");
    ramp(s, "Omega", 0.0);
    ramp(s, "WOB", -1e8);
    REQUIRE(run, !subject_step(s, s->known.time, 0.01), "a step to a negative weight is taken");
    ramp(s, "WOB", 0.0);
    REQUIRE(run, !subject_step(s, s->known.time, 1e300), "a step of 1e300 s is taken");
    go(s, 0.01);
    finish(s);
}

/* a light bit on rock whose friction falls at once, which a wave of 1e4 rad/s throws about faster than can be followed:
 * steps of all lengths that are refused, within a travel time and over several of them, and shorter ones between */
static void too_fast(session *run, subject *s)
{
    static const double LONG[] = {0.4, 1.0, 2.5, 20.0};
    static const setting WILD[] = {{"v_f", 1e-6}, {"mu_cb", 0.0}, {"mu_sb", 1.0}, {"I_B", 1.0}, {NULL, 0.0}};
    for (int damped = 0; damped < (variable_named("beta") >= 0 ? 2 : 1); ++damped) {
        subject_instantiate(s, run, "fast", SOUND, 1);
        s->watched = 1;
        for (const setting *p = WILD; p->name != NULL; ++p) {
            put(s, p->name, p->value);
        }
        if (damped) {
            put(s, "beta", 1.0);
        }
        subject_set_up(s, 0.0, 0, 0.0);
        subject_enter(s);
        REQUIRE(run, subject_exit(s), "the start is refused");
        ramp(s, "Omega", 9e4);
        go(s, 0.1);
        put(s, "Omega", 9010.0);
        for (int i = 0; i < 12; ++i) {
            put(s, "mu_sb", 0.9 + 0.01 * i);
            REQUIRE(run, !subject_step(s, s->known.time, LONG[i % 4]), "a bit that is too fast is followed");
            go(s, 0.02);
        }
        for (int i = 0; i < 400; ++i) { /* on to where it is too fast, and there from one change of an input to the next */
            put(s, i % 3 == 0 ? "mu_sb" : "WOB", i % 3 == 0 ? 0.9 + 0.01 * (i % 7) : 9e4 + 1e3 * (i % 5));
            subject_step(s, s->known.time, i < 50 ? 1e-3 : 1e-5 * (1 + i % 9));
        }
        finish(s);
    }
}

/* a friction that fades within a speed that no halving of a piece resolves, and a travel time of a whole number of the
 * longest cells */
static void rough_and_even(session *run, subject *s)
{
    static const setting ROUGH[] = {{"cells", 4.0}, {"L", 1e5}, {"v_f", 1e-6}, {"initial_torque", 2e6}, {"Omega", 1e3},
                                    {"WOB", 1e7}, {NULL, 0.0}};
    static const setting EVEN[] = {{"G", 8e10}, {"J", 1.25e-5}, {"I", 0.01}, {"L", 5000.0}, {NULL, 0.0}};
    start(s, run, ROUGH, 0.0);
    go(s, 5e-324); /* of which no block of seconds is a part that can be told from 0 */
    go_on(s, 5.0);
    REQUIRE(run, subject_value(s, "bit_speed") > 0.0, "the bit does not turn");
    finish(s);
    start(s, run, EVEN, 0.0);
    REQUIRE(run, subject_value(s, "cells_used") == 1000.0, "%g cells are used", subject_value(s, "cells_used"));
    go_on(s, 1.0);
    finish(s);
}

/* each parameter at both ends of its range, on a few cells, over some travel times: what would take long is refused */
static void extremes(session *run, subject *s)
{
    for (int i = 0; i < 2 * DS_VARIABLES; ++i) {
        const ds_variable *const variable = &ds_variables[i / 2];
        if (variable->role == DS_OUTPUT || variable->kind != DS_REAL) {
            continue;
        }
        subject_instantiate(s, run, "extreme", SOUND, 1);
        put(s, "cells", 12.0);
        put(s, "initial_speed", 2.0);
        put(s, variable->name, i % 2 == 0 ? variable->minimum : variable->maximum);
        subject_set_up(s, 0.0, 0, 0.0);
        subject_enter(s);
        if (subject_exit(s)) {
            const double longest = plant_travel_time(s);
            for (int k = 0; k < 40; ++k) {
                go(s, longest * STEP_SIZE[k % STEP_SIZES]);
            }
            subject_terminate(s);
        }
        subject_free(s);
        memset(s, 0, sizeof *s);
    }
}

/* a state taken in mid-stick and in mid-cell, carried on by the instance, by itself again, and by another instance */
static void states(session *run, subject *s)
{
    static const setting SETTINGS[] = {{"cells", 97.0}, {NULL, 0.0}};
    static const setting OTHERS[] = {{"cells", 30.0}, {"L", 2000.0}, {"c_b", 5.0}, {NULL, 0.0}};
    saved_state kept = {NULL, {0}};
    saved_state moved = {NULL, {0}};
    subject other = {0};
    start(s, run, SETTINGS, 0.0);
    start(&other, run, OTHERS, 5.0);
    for (int i = 0; i < 6; ++i) {
        go_on(s, 0.777);
        ramp(s, "Omega", 0.5);
        subject_save(s, &kept);
        subject_copy(s, &kept, &moved);
        go_on(s, 1.1);
        subject_restore(s, &kept);
        subject_repeat(s, 1.1);
        subject_restore(&other, &moved);
        go_on(&other, 1.1);
    }
    subject_forget(s, &kept);
    subject_forget(&other, &moved);
    finish(&other);
    finish(s);
}

/* points added up by an importer, which drift from the instance's own time */
static void drift(session *run, subject *s)
{
    static const setting SETTINGS[] = {{"cells", 20.0}, {NULL, 0.0}};
    double point = 0.1;
    start(s, run, SETTINGS, point);
    for (int i = 0; i < 3000; ++i) {
        REQUIRE(run, subject_step(s, point, 0.001), "a step from %.17g s is refused", point);
        point += 0.001;
    }
    finish(s);
}

static void plant_at_its_corners(session *run, subject *s)
{
    static const char *const OUTPUTS[] = {"bit_speed", "top_speed", "bit_torque", "top_torque", "energy"};
    static const setting CORNERS[][4] = {
        {{"cells", 40.0}, {NULL, 0.0}},
        {{"cells", 40.0}, {"initial_speed", 6.0}, {"initial_torque", 7500.0}, {NULL, 0.0}},
        {{"cells", 40.0}, {"initial_torque", -2e4}, {"mu_cb", 0.8}, {NULL, 0.0}},
    };
    for (size_t i = 0; i < 15; ++i) {
        differentiate_at(run, s, CORNERS[i / 5], OUTPUTS[i % 5]);
    }
}

/* inputs that change at the ends of blocks, and next to them, where the change snaps to the end */
static void ends_of_blocks(session *run, subject *s)
{
    static const double BESIDE[] = {0.0, 1e-13, -1e-13, 3e-12, -3e-12, 1e-10, -1e-10};
    static const setting SETTINGS[] = {
        {"cells", 64.0}, {"initial_speed", 6.0}, {"initial_torque", 7500.0}, {NULL, 0.0}};
    start(s, run, SETTINGS, 0.0);
    const double block = plant_travel_time(s) / 8.0;
    for (int i = 1; i < 300; ++i) {
        go(s, (i - 0.6) * block - s->known.time);
        go(s, (i + BESIDE[i % 7]) * block - s->known.time);
        put(s, i % 2 == 0 ? "Omega" : "WOB", i % 2 == 0 ? 10.0 + i % 5 : 9e4 + 100.0 * (i % 9));
        if (i % 3 == 0) {
            put(s, "c_b", 0.1 * (i % 4));
            ramp(s, i % 2 == 0 ? "WOB" : "Omega", 3.0);
        }
    }
    finish(s);
}

const walk walks_of_plants[] = {
    {"bit_stuck", "stick-slip", stick_slip},
    {"bit_stuck", "jumps", jumps},
    {"bit_stuck", "ramps", ramps},
    {"bit_stuck", "reverse", reverse},
    {"bit_stuck", "chatter", chatter},
    {"bit_stuck", "overflow", overflow},
    {"bit_stuck", "refusals", refusals},
    {"bit_stuck", "too fast", too_fast},
    {"bit_stuck", "rough and even", rough_and_even},
    {"bit_stuck", "extremes", extremes},
    {"bit_stuck", "states", states},
    {"bit_stuck", "drift", drift},
    {"bit_stuck", "ends", ends_of_blocks},
    {"bit_stuck", "corners", plant_at_its_corners},
    {NULL, NULL, NULL},
};
