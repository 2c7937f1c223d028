#include "subject.h"

#include <math.h>
#include <string.h>

#include "judge.h"
#include "laws.h"

int variable_named(const char *name)
{
    for (int i = 0; i < DS_VARIABLES; ++i) {
        if (strcmp(ds_variables[i].name, name) == 0) {
            return i;
        }
    }
    return -1;
}

double subject_value(const subject *s, const char *name)
{
    return s->known.value[variable_named(name)];
}

void subject_describe(const subject *s)
{
    fprintf(stderr, "%s at t = %.17g s since %.17g s:", s->name, s->known.time, s->known.start);
    for (int i = 0; i < DS_VARIABLES; ++i) {
        fprintf(stderr, " %s = %.17g,", ds_variables[i].name, s->known.value[i]);
    }
    fputc('\n', stderr);
}

/* what is known of an instance that has just been made or reset */
static void forget_all(subject *s)
{
    knowledge *const known = &s->known;
    memset(known, 0, sizeof *known);
    known->phase = INSTANTIATED;
    known->unread = 1;
    for (int i = 0; i < DS_VARIABLES; ++i) {
        known->value[i] = ds_variables[i].start;
    }
}

/* whether the subject is there and in one of the phases */
static int is_in(const subject *s, int phases)
{
    return s->component != NULL && (s->known.phase & phases) != 0;
}

static fmi2String flawed_name(const char *name, flaw what)
{
    return what == NO_NAME || what == NOTHING ? NULL : what == EMPTY_NAME ? " \t" : name;
}

static fmi2String flawed_guid(flaw what)
{
    return what == NO_GUID ? NULL : what == OTHER_GUID || what == UNHEARD ? "{another}" : DS_GUID;
}

void subject_instantiate(subject *s, session *run, const char *name, flaw what, int logging)
{
    const int sound = what == SOUND || what == SILENT;
    const int heard = what != UNHEARD && what != SILENT && what != NO_CALLBACKS && what != NOTHING;
    const fmi2CallbackFunctions callbacks = {heard ? judge_logger : NULL, NULL, NULL, NULL, s};
    s->run = run;
    s->callbacks = callbacks;
    s->component = NULL;
    s->fresh = 0;
    s->discards_told = 1;
    snprintf(s->name, sizeof s->name, "%s", name);
    judge_begin(s, "fmi2Instantiate");
    s->component = run->fmi.Instantiate(flawed_name(name, what),
                                        what == MODEL_EXCHANGE ? fmi2ModelExchange : fmi2CoSimulation,
                                        flawed_guid(what), "file:///resources",
                                        what == NO_CALLBACKS || what == NOTHING ? NULL : &s->callbacks, fmi2False,
                                        logging);
    judge_end(s, s->component != NULL ? fmi2OK : fmi2Error, sound ? ALLOW_OK : ALLOW_ERROR);
    REQUIRE(run, s->component != NULL || !heard || s->told != 0, "refused in silence");
    forget_all(s);
}

void subject_free(subject *s)
{
    judge_begin(s, "fmi2FreeInstance");
    if (s->shadow != NULL) {
        s->run->fmi.FreeFMUstate(s->component, &s->shadow);
    }
    s->run->fmi.FreeInstance(s->component);
    judge_end(s, fmi2OK, ALLOW_OK);
    s->component = NULL;
}

/* whether a log category exists; whether it is that of refusals, which are then told as `on` says */
static int is_category(subject *s, const char *name, int on)
{
    for (int i = 0; i < DS_LOG_CATEGORIES; ++i) {
        if (name != NULL && strcmp(name, ds_log_categories[i]) == 0) {
            const int counts = strcmp(name, "logStatusDiscard") == 0 || strcmp(name, "logAll") == 0;
            s->discards_told = counts ? on : s->discards_told;
            return 1;
        }
    }
    return 0;
}

void subject_set_logging(subject *s, int on, size_t n, const fmi2String categories[])
{
    const int former = s->discards_told;
    int allowed = is_in(s, ANY_TIME) ? ALLOW_OK : ALLOW_ERROR;
    s->discards_told = n == 0 ? on : s->discards_told;
    for (size_t i = 0; i < n; ++i) {
        allowed = categories != NULL && is_category(s, categories[i], on) ? allowed : ALLOW_ERROR;
    }
    judge_begin(s, "fmi2SetDebugLogging");
    if (!judge_end(s, s->run->fmi.SetDebugLogging(s->component, on, n, categories), allowed)) {
        s->discards_told = former;
    }
}

void subject_set_up(subject *s, double start, int stop_defined, double stop)
{
    const int sound = isfinite(start) && (!stop_defined || stop > start);
    const int legal = is_in(s, INSTANTIATED);
    judge_begin(s, "fmi2SetupExperiment");
    const fmi2Status status = s->run->fmi.SetupExperiment(s->component, fmi2True, 1e-6, start, stop_defined, stop);
    if (judge_end(s, status, legal && sound ? ALLOW_OK : legal ? ALLOW_ERROR | ALLOW_DISCARD : ALLOW_ERROR)) {
        s->known.set_up = 1;
        s->known.start = start;
        s->known.time = start;
    }
}

void subject_enter(subject *s)
{
    /* whether an experiment that was not set up is an error is for the FMU to say */
    const int allowed = s->known.set_up ? ALLOW_OK : ALLOW_OK | ALLOW_ERROR;
    const int legal = is_in(s, INSTANTIATED);
    judge_begin(s, "fmi2EnterInitializationMode");
    if (judge_end(s, s->run->fmi.EnterInitializationMode(s->component), legal ? allowed : ALLOW_ERROR)) {
        s->known.phase = INITIALIZATION;
    }
}

int subject_exit(subject *s)
{
    const int legal = is_in(s, INITIALIZATION);
    judge_begin(s, "fmi2ExitInitializationMode");
    const fmi2Status status = s->run->fmi.ExitInitializationMode(s->component);
    if (!judge_end(s, status, legal ? ALLOW_OK | ALLOW_ERROR : ALLOW_ERROR)) {
        return 0;
    }
    s->known.phase = STEPPING;
    s->known.unread = 0;
    subject_read(s);
    laws_hold(s, NULL);
    return 1;
}

void subject_terminate(subject *s)
{
    const int legal = is_in(s, STEPPING);
    judge_begin(s, "fmi2Terminate");
    if (judge_end(s, s->run->fmi.Terminate(s->component), legal ? ALLOW_OK : ALLOW_ERROR)) {
        s->known.phase = TERMINATED;
    }
}

void subject_reset(subject *s)
{
    const int legal = is_in(s, ANY_TIME);
    judge_begin(s, "fmi2Reset");
    if (judge_end(s, s->run->fmi.Reset(s->component), legal ? ALLOW_OK : ALLOW_ERROR)) {
        forget_all(s);
    }
}

int subject_step(subject *s, double point, double size)
{
    const int legal = is_in(s, STEPPING);
    const double time = s->known.time;
    const int sound = isfinite(size) && size > 0.0 && fabs(point - time) <= 1e-9 * fmax(1.0, fabs(time)) + 1e-6 * size;
    const knowledge before = s->known;
    judge_begin(s, "fmi2DoStep");
    const fmi2Status status = s->run->fmi.DoStep(s->component, point, size, fmi2False);
    if (!judge_end(s, status, !legal ? ALLOW_ERROR : sound ? ALLOW_OK | ALLOW_DISCARD : ALLOW_DISCARD)) {
        return 0;
    }
    s->known.time = point + size;
    s->known.unread = 0;
    subject_read(s);
    laws_hold(s, &before);
    s->known.ramped = 0;
    return 1;
}

void subject_cancel(subject *s)
{
    judge_begin(s, "fmi2CancelStep");
    judge_end(s, s->run->fmi.CancelStep(s->component), ALLOW_ERROR);
}

void subject_ask_statuses(subject *s, fmi2StatusKind kind, int null)
{
    const fmi_functions *const fmi = &s->run->fmi;
    const int refused = s->component == NULL ? ALLOW_ERROR : ALLOW_ERROR | ALLOW_DISCARD;
    const int due = is_in(s, STEPPING | TERMINATED) && !null;
    const int maybe = s->component == NULL || null ? refused : refused | ALLOW_OK;
    fmi2Status status = fmi2OK;
    double real = 0.0;
    fmi2Integer integer = 0;
    fmi2Boolean boolean = fmi2True;
    fmi2String text = NULL;
    judge_begin(s, "fmi2GetStatus");
    judge_end_of_reading(s, fmi->GetStatus(s->component, kind, null ? NULL : &status), maybe);
    judge_begin(s, "fmi2GetRealStatus");
    if (judge_end_of_reading(s, fmi->GetRealStatus(s->component, kind, null ? NULL : &real),
                             due && kind == fmi2LastSuccessfulTime ? ALLOW_OK : maybe)) {
        REQUIRE(s->run, real == s->known.time, "the last successful time is %.17g s, not %.17g s", real, s->known.time);
    }
    judge_begin(s, "fmi2GetIntegerStatus");
    judge_end_of_reading(s, fmi->GetIntegerStatus(s->component, kind, null ? NULL : &integer), maybe);
    judge_begin(s, "fmi2GetBooleanStatus");
    if (judge_end_of_reading(s, fmi->GetBooleanStatus(s->component, kind, null ? NULL : &boolean),
                             due && kind == fmi2Terminated ? ALLOW_OK : maybe)) {
        REQUIRE(s->run, !boolean, "the instance wants to terminate");
    }
    judge_begin(s, "fmi2GetStringStatus");
    judge_end_of_reading(s, fmi->GetStringStatus(s->component, kind, null ? NULL : &text), maybe);
}
