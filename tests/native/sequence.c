#include "sequence.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "allocation.h"
#include "operations.h"
#include "plant.h"

/* messages show 64 bytes of a name, which end within the third euro sign */
#define LONG_NAME "a Gest\xc3\xa4nge with a name that messages show a part of only: " EURO EURO EURO EURO EURO
#define EURO "\xe2\x82\xac"
#define MOST_CELLS 3000.0      /* 1, cells of a plant, so that a sequence takes milliseconds */
#define REFUSED_CELLS 1e7      /* 1, more are refused by the plant, so they cost nothing */
#define LONGEST_CELL 0.0005    /* s, of a plant that chooses its cells itself */
#define CELLS_A_STEP 400.0     /* 1, longest step of a plant, which itself refuses to follow its bit at any cost */

enum { SEQUENCE_BYTES = 2048 };

static saved_state *choose_slot(sequence *q)
{
    return &q->slots[choose_below(&q->from, SLOTS)];
}

static double cells_of(const subject *s)
{
    const double set = subject_value(s, "cells");
    return fmax(set > 0.0 ? set : plant_travel_time(s) / LONGEST_CELL, 4.0);
}

void bound_cells(sequence *q, subject *s)
{
    if (s->component == NULL || s->known.phase != INITIALIZATION || !is_plant()) {
        return;
    }
    const double set = subject_value(s, "cells");
    const double cells = set > 0.0 ? set : plant_travel_time(s) / LONGEST_CELL;
    if (cells > MOST_CELLS && cells <= 1.01 * REFUSED_CELLS) {
        const fmi2ValueReference vr = (fmi2ValueReference)variable_named("cells");
        const double fewer = 4.0 + choose_below(&q->from, 64);
        subject_set(s, DS_INTEGER, &vr, 1, &fewer, NONE_NULL);
    }
}

/* s, the longest step that takes milliseconds */
static double longest_step(const subject *s)
{
    if (!is_plant()) {
        return 1.0;
    }
    return CELLS_A_STEP * plant_travel_time(s) / cells_of(s);
}

static double choose_step(sequence *q, const subject *s)
{
    const double longest = longest_step(s);
    const double x = choose_fraction(&q->from);
    if (is_plant() && choose_below(&q->from, 8) == 0) {
        /* to the end of a block, or so close to it that an input change snaps to it */
        const double parts = 1 << choose_below(&q->from, 3);
        return fmin(longest, plant_travel_time(s) / parts * (1.0 + 1e-13 * (choose_byte(&q->from) % 8 - 4)));
    }
    return longest * choose_scale(&q->from) * (0.25 + 0.75 * x);
}

static void op_instantiate(sequence *q, subject *s)
{
    static const char *const NAMES[] = {"plant", LONG_NAME, "#1"};
    const int what = choose_below(&q->from, 16);
    if (s->component != NULL) {
        subject_free(s);
    }
    s->watched = q->watched;
    subject_instantiate(s, q->run, NAMES[choose_below(&q->from, 3)], what <= (int)SILENT ? (flaw)what : SOUND,
                        choose_below(&q->from, 2));
}

static void op_free(sequence *q, subject *s)
{
    (void)q;
    subject_free(s);
}

static void op_set_up(sequence *q, subject *s)
{
    static const double STARTS[] = {0.0, 2.5, -10.0, 1e6, 0.0, NAN, INFINITY, 0.1};
    const double start = STARTS[choose_below(&q->from, 8)];
    const int stop_defined = choose_below(&q->from, 2);
    subject_set_up(s, start, stop_defined, start + (choose_below(&q->from, 8) == 0 ? -1.0 : 1.0));
}

static void op_enter(sequence *q, subject *s)
{
    (void)q;
    subject_enter(s);
}

static void op_exit(sequence *q, subject *s)
{
    bound_cells(q, s);
    subject_exit(s);
}

static void op_terminate(sequence *q, subject *s)
{
    (void)q;
    subject_terminate(s);
}

static void op_reset(sequence *q, subject *s)
{
    (void)q;
    subject_reset(s);
}

static void op_step(sequence *q, subject *s)
{
    const double time = s->known.time;
    const double size = choose_step(q, s);
    const double drift = choose_below(&q->from, 4) == 0 ? 1e-9 * choose_fraction(&q->from) : 0.0;
    subject_step(s, time + fmax(1.0, fabs(time)) * drift, size);
}

static void op_step_on(sequence *q, subject *s)
{
    const int n = choose_below(&q->from, 32);
    const double size = choose_step(q, s);
    for (int i = 0; i < n && subject_step(s, s->known.time, size); ++i) {
    }
}

/* a step of a size or from a point that no importer means */
static void op_misstep(sequence *q, subject *s)
{
    static const double SIZES[] = {0.0, -1.0, NAN, INFINITY, -INFINITY, 5e-324, 1e300, 1e-300};
    static const double OFFSETS[] = {0.0, 1.0, -1.0, NAN, INFINITY, 1e-3, -1e-3, 1e300};
    const double size = SIZES[choose_below(&q->from, 8)];
    const double offset = OFFSETS[choose_below(&q->from, 8)];
    subject_step(s, s->known.time + offset, offset == 0.0 ? size : choose_step(q, s));
}

static void op_save(sequence *q, subject *s)
{
    subject_save(s, choose_below(&q->from, 32) == 0 ? NULL : choose_slot(q));
}

static void op_restore(sequence *q, subject *s)
{
    subject_restore(s, choose_slot(q));
}

static void op_forget(sequence *q, subject *s)
{
    subject_forget(s, choose_below(&q->from, 32) == 0 ? NULL : choose_slot(q));
}

static void op_copy(sequence *q, subject *s)
{
    const saved_state *const from = choose_slot(q);
    saved_state *const to = choose_slot(q);
    if (to != from) {
        subject_copy(s, from, to);
    }
}

static void op_damage(sequence *q, subject *s)
{
    const saved_state *const from = choose_slot(q);
    saved_state *const to = choose_slot(q);
    const size_t high = choose_byte(&q->from);
    const size_t place = choose_below(&q->from, 2) ? high : high * 256 + choose_byte(&q->from);
    const size_t size = choose_below(&q->from, 2) ? SIZE_MAX : place;
    subject_damage(s, from, to, place, choose_byte(&q->from), size);
}

static void op_repeat(sequence *q, subject *s)
{
    if (s->component != NULL && s->known.phase == STEPPING && q->run->starve == 0) {
        subject_repeat(s, choose_step(q, s));
    }
}

static void op_misuse(sequence *q, subject *s)
{
    subject_misuse_states(s, choose_slot(q));
}

static void op_log(sequence *q, subject *s)
{
    const fmi2String names[] = {ds_log_categories[0], ds_log_categories[DS_LOG_CATEGORIES - 1], "nonsense", NULL};
    const fmi2String chosen[2] = {names[choose_below(&q->from, 4)], names[choose_below(&q->from, 2)]};
    const int n = choose_below(&q->from, 3);
    subject_set_logging(s, choose_below(&q->from, 2), (size_t)n, choose_below(&q->from, 8) == 0 ? NULL : chosen);
}

static void op_ask(sequence *q, subject *s)
{
    subject_ask_statuses(s, (fmi2StatusKind)choose_below(&q->from, 4), choose_below(&q->from, 8) == 0);
    subject_cancel(s);
}

/* let one of the next allocations fail */
static void op_starve(sequence *q, subject *s)
{
    (void)s;
    q->run->starve = 1 + choose_below(&q->from, 4);
}

/* set sound parameters and go to the first communication point */
static void op_start(sequence *q, subject *s)
{
    const int parameters = choose_below(&q->from, 12);
    subject_reset(s);
    for (int i = 0; i < parameters; ++i) {
        set_some(q, s, choose_below(&q->from, 4) == 0 ? DS_INTEGER : DS_REAL);
    }
    subject_set_up(s, choose_below(&q->from, 2) ? 0.0 : 2.5, 0, 0.0);
    subject_enter(s);
    op_exit(q, s);
}

/* what the bytes stand for; what makes time pass is there more than once */
static void (*const OPERATIONS[])(sequence *q, subject *s) = {
    op_step,       op_step,         op_step,         op_step,     op_step_on,    op_step_on,    op_drive,
    op_drive,      op_drive,        op_start,        op_start,    op_start,      op_repeat,     op_repeat,
    op_save,       op_save,         op_restore,      op_restore,  op_forget,     op_copy,       op_damage,
    op_set_reals,  op_set_reals,    op_set_integers, op_set_texts, op_set_texts, op_set_slopes, op_set_slopes,
    op_get,        op_read,         op_get_slopes,   op_get_sensitivities,       op_misstep,    op_set_booleans,
    op_set_up,     op_enter,        op_exit,         op_exit,     op_terminate,  op_reset,      op_instantiate,
    op_free,       op_misuse,       op_log,          op_ask,          op_starve,
};

enum { COUNT = sizeof OPERATIONS / sizeof *OPERATIONS };

/* free what is left, in an order that the bytes decide */
static void end(sequence *q)
{
    subject *const last = &q->subjects[choose_below(&q->from, SUBJECTS)];
    q->run->starve = 0;
    if (last->component == NULL) {
        subject_instantiate(last, q->run, "last", SOUND, 0);
    }
    for (int i = 0; i < SUBJECTS; ++i) {
        if (&q->subjects[i] != last) {
            subject_free(&q->subjects[i]);
        }
    }
    for (int i = 0; i < SLOTS; ++i) {
        subject_forget(last, &q->slots[i]);
    }
    subject_free(last);
    for (int i = 0; i < SUBJECTS; ++i) {
        free(q->subjects[i].before.bytes);
        free(q->subjects[i].after.bytes);
    }
}

void sequence_run(session *run, const uint8_t *bytes, size_t n)
{
    const long live = allocation_live();
    sequence *const q = calloc(1, sizeof *q);
    REQUIRE(run, q != NULL, "no memory for the driver");
    q->run = run;
    q->from.bytes = bytes;
    q->from.left = n;
    const int kind = choose_below(&q->from, 8);
    q->wild = (kind & 3) == 0;
    q->watched = (kind & 4) == 0;
    for (int i = 0; i < SUBJECTS; ++i) {
        q->subjects[i].run = run;
    }
    while (q->from.left > 0) {
        subject *const s = &q->subjects[choose_below(&q->from, SUBJECTS)];
        const int operation = choose_below(&q->from, COUNT);
        if (s->component == NULL && choose_below(&q->from, 8) != 0) {
            op_instantiate(q, s);
        } else {
            OPERATIONS[operation](q, s);
        }
    }
    end(q);
    free(q);
    REQUIRE(run, allocation_live() == live, "%ld blocks are not freed", allocation_live() - live);
}

unsigned long sequence_run_seeds(session *run, unsigned long seed, unsigned long calls, FILE *report)
{
    uint8_t bytes[SEQUENCE_BYTES];
    unsigned long made = 0;
    while (made < calls) {
        session_begin(run, "seed", seed);
        choices_of_seed(seed, bytes, sizeof bytes);
        sequence_run(run, bytes, sizeof bytes);
        fprintf(report, "seed %lu: %lu calls, %016" PRIx64 "\n", seed, run->calls, run->digest);
        made += run->calls;
        seed += 1;
    }
    return made;
}
