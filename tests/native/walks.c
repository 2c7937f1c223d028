#include "walks.h"

#include <inttypes.h>
#include <stdlib.h>

#include "walking.h"

/* every kind of call to an instance that is not there */
static void nobody(session *run, subject *s)
{
    const fmi2ValueReference vr = 0;
    const fmi2Integer order = 1;
    const double value = 1.0;
    saved_state none = {NULL, {0}};
    s->run = run;
    subject_free(s);
    subject_set_logging(s, 1, 0, NULL);
    subject_set_up(s, 0.0, 0, 0.0);
    subject_enter(s);
    subject_exit(s);
    subject_step(s, 0.0, 0.1);
    subject_terminate(s);
    subject_reset(s);
    subject_read(s);
    subject_set(s, ds_variables[0].kind, &vr, 1, &value, NONE_NULL);
    subject_set_slopes(s, &vr, 1, &order, &value, NONE_NULL);
    subject_get_slopes(s, &vr, 1, &order, NONE_NULL);
    subject_get_sensitivities(s, &vr, 1, &vr, 1, &value, 0);
    subject_ask_statuses(s, fmi2Terminated, 0);
    subject_cancel(s);
    subject_save(s, &none);
    subject_restore(s, &none);
    subject_copy(s, &none, &none);
    subject_forget(s, &none);
    subject_misuse_states(s, &none);
}

/* a serialised state with each of its first bytes changed, and cut off at each */
static void damages(session *run, subject *s)
{
    static const setting NOMINAL[] = {{NULL, 0.0}};
    saved_state kept = {NULL, {0}};
    saved_state spoilt = {NULL, {0}};
    start(s, run, NOMINAL, 0.0);
    subject_save(s, &kept);
    for (size_t i = 0; i < 160; ++i) {
        subject_damage(s, &kept, &spoilt, i, (unsigned char)(1u << i % 8), SIZE_MAX);
        subject_damage(s, &kept, &spoilt, i, 1, i);
    }
    subject_forget(s, &kept);
    finish(s);
}

static void make(session *run, const walk *to_make)
{
    subject s = {0};
    session_begin(run, to_make->name, 0);
    session_see_text(run, to_make->name);
    to_make->walk(run, &s);
    fprintf(run->out, "digest %016" PRIx64 "\n", run->digest);
}

static void make_each(session *run, const walk walks[])
{
    for (int i = 0; walks[i].walk != NULL; ++i) {
        if (variable_named(walks[i].needs) >= 0) {
            make(run, &walks[i]);
        }
    }
}

void walk_all(session *run)
{
    static const walk NOBODY = {NULL, "nobody", nobody};
    static const walk DAMAGES = {NULL, "damages", damages};
    make(run, &NOBODY);
    make(run, &DAMAGES);
    make_each(run, walks_of_plants);
    make_each(run, walks_of_laws);
}

/* an instance at its first communication point, whatever had to be repeated */
static void live(subject *s, session *run, int variant)
{
    subject_instantiate(s, run, "alive", SOUND, variant % 2);
    if (s->component == NULL) {
        subject_instantiate(s, run, "alive", SOUND, variant % 2);
    }
    if (variable_named("cells") >= 0) {
        put(s, "cells", 8.0 + variant);
    }
    if (variable_named("table") >= 0) {
        set_table(s, SOUND_TABLE);
    }
    subject_set_up(s, 0.0, 0, 0.0);
    subject_enter(s);
    REQUIRE(run, subject_exit(s) || subject_exit(s), "the initialization is refused again");
}

static void save_twice(subject *s, saved_state *slot)
{
    subject_save(s, slot);
    if (slot->state == NULL) {
        subject_save(s, slot);
    }
}

void walk_life(session *run)
{
    subject one = {0};
    subject other = {0};
    saved_state kept = {NULL, {0}};
    saved_state copied = {NULL, {0}};
    one.watched = run->starve > 0;
    live(&one, run, 0);
    live(&other, run, 5);
    go(&one, 0.05);
    save_twice(&one, &kept);
    subject_copy(&one, &kept, &copied);
    subject_save(&other, &kept);
    subject_save(&other, &kept);
    subject_restore(&one, &kept);
    subject_restore(&one, &kept);
    go(&one, 0.02);
    if (copied.state != NULL) {
        subject_restore(&other, &copied);
        subject_restore(&other, &copied);
        go(&other, 0.02);
    }
    subject_reset(&one);
    subject_forget(&other, &copied);
    subject_forget(&one, &kept);
    subject_terminate(&other);
    subject_free(&one);
    subject_free(&other);
    free(one.before.bytes);
    free(one.after.bytes);
}

void walk_refusals(session *run)
{
    for (int what = NO_NAME; what < (int)SILENT; ++what) {
        subject s = {0};
        subject_instantiate(&s, run, "refused", (flaw)what, 1);
        subject_free(&s);
    }
}
