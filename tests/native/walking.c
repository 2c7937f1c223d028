#include "walking.h"

#include <stdlib.h>
#include <string.h>

const double STEP_SIZE[STEP_SIZES] = {0.01, 0.0137, 1e-4, 0.31, 1.0 / 3.0, 0.002, 7e-6, 0.05};

int put(subject *s, const char *name, double value)
{
    const int number = variable_named(name);
    REQUIRE(s->run, number >= 0, "there is no variable %s", name);
    const fmi2ValueReference vr = (fmi2ValueReference)number;
    return subject_set(s, ds_variables[number].kind, &vr, 1, &value, NONE_NULL);
}

void ramp(subject *s, const char *name, double slope)
{
    const fmi2ValueReference vr = (fmi2ValueReference)variable_named(name);
    const fmi2Integer order = 1;
    subject_set_slopes(s, &vr, 1, &order, &slope, NONE_NULL);
}

void go(subject *s, double size)
{
    REQUIRE(s->run, subject_step(s, s->known.time, size), "a step of %g s is refused", size);
}

void read_slopes(subject *s)
{
    fmi2ValueReference vr[DS_VARIABLES];
    fmi2Integer order[DS_VARIABLES];
    size_t n = 0;
    for (int i = 0; i < DS_VARIABLES; ++i) {
        if (ds_variables[i].kind == DS_REAL && ds_variables[i].role == DS_OUTPUT) {
            order[n] = 1;
            vr[n++] = (fmi2ValueReference)i;
        }
    }
    subject_get_slopes(s, vr, n, order, NONE_NULL);
}

void go_on(subject *s, double duration)
{
    const double end = s->known.time + duration;
    for (int i = 0; s->known.time < end; i = (i + 1) % STEP_SIZES) {
        go(s, STEP_SIZE[i]);
        read_slopes(s);
    }
}

void start(subject *s, session *run, const setting settings[], double time)
{
    subject_instantiate(s, run, "walker", SOUND, 1);
    for (int i = 0; settings[i].name != NULL; ++i) {
        put(s, settings[i].name, settings[i].value);
    }
    subject_set_up(s, time, 0, 0.0);
    subject_enter(s);
    subject_exit(s);
}

void finish(subject *s)
{
    subject_terminate(s);
    subject_read(s);
    subject_free(s);
    free(s->before.bytes);
    free(s->after.bytes);
    memset(s, 0, sizeof *s);
}

/* derivatives in the direction of one variable at a time, by parameters too while they can be set */
static void differentiate(subject *s, const char *output)
{
    const fmi2ValueReference unknown = (fmi2ValueReference)variable_named(output);
    for (int i = 0; i < DS_VARIABLES; ++i) {
        const fmi2ValueReference known = (fmi2ValueReference)i;
        for (int sign = -1; sign <= 1; sign += 2) {
            const double seed = sign;
            if (ds_variables[i].kind == DS_REAL) {
                subject_get_sensitivities(s, &unknown, 1, &known, 1, &seed, 0);
            }
        }
    }
}

void differentiate_at(session *run, subject *s, const setting settings[], const char *output)
{
    subject_instantiate(s, run, "corner", SOUND, 1);
    for (int i = 0; settings[i].name != NULL; ++i) {
        put(s, settings[i].name, settings[i].value);
    }
    subject_set_up(s, 0.0, 0, 0.0);
    subject_enter(s);
    differentiate(s, output);
    subject_exit(s);
    differentiate(s, output);
    go(s, 0.01);
    differentiate(s, output);
    finish(s);
}
