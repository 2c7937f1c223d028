/* Setting and reading variables of a subject, soundly or not. */
#include <math.h>
#include <string.h>

#include "judge.h"

#define SETTABLE (INSTANTIATED | INITIALIZATION | STEPPING)

enum { MOST = DS_VARIABLES + 8 };

/* numbers in an array of the type a kind of variable has */
typedef union {
    fmi2Real reals[MOST];
    fmi2Integer integers[MOST];
    fmi2Boolean booleans[MOST];
    fmi2String texts[MOST];
} typed_array;

static const char *const SETTERS[] = {"fmi2SetReal", "fmi2SetInteger", "fmi2SetBoolean", "fmi2SetString"};
static const char *const GETTERS[] = {"fmi2GetReal", "fmi2GetInteger", "fmi2GetBoolean", "fmi2GetString"};

/* begin a call that may pass no instance on purpose */
static fmi2Component begin(subject *s, const char *call, null_argument null)
{
    judge_begin(s, call);
    if (null == NULL_COMPONENT) {
        s->addressed = NULL;
    }
    return s->addressed;
}

/* in initialization mode, reading brings the outputs up to date */
static int end_of_reading(subject *s, fmi2Status status, int allowed)
{
    return s->known.phase == INITIALIZATION ? judge_end(s, status, allowed) : judge_end_of_reading(s, status, allowed);
}

/* whether the call can reach the instance and its references are of one kind */
static int is_well_formed(const subject *s, int phases, const fmi2ValueReference vr[], size_t n, ds_kind kind,
                          null_argument null)
{
    const int reached = s->component != NULL && null != NULL_COMPONENT && (s->known.phase & phases) != 0;
    if (!reached || (n > 0 && null != NONE_NULL)) {
        return 0;
    }
    for (size_t i = 0; i < n; ++i) {
        if (vr[i] >= DS_VARIABLES || ds_variables[vr[i]].kind != kind) {
            return 0;
        }
    }
    return 1;
}

static int are_settable(const subject *s, const fmi2ValueReference vr[], size_t n)
{
    for (size_t i = 0; i < n; ++i) {
        const ds_role role = ds_variables[vr[i]].role;
        if (role == DS_OUTPUT || (role == DS_FIXED && s->known.phase == STEPPING)) {
            return 0;
        }
    }
    return 1;
}

static int are_in_range(const fmi2ValueReference vr[], size_t n, const double value[])
{
    for (size_t i = 0; i < n; ++i) {
        const ds_variable *const variable = &ds_variables[vr[i]];
        if (variable->kind != DS_BOOLEAN && !(value[i] >= variable->minimum && value[i] <= variable->maximum)) {
            return 0;
        }
    }
    return 1;
}

static fmi2Status set_typed(const subject *s, fmi2Component c, ds_kind kind, const fmi2ValueReference *vr, size_t n,
                            const double value[], int null)
{
    const fmi_functions *const fmi = &s->run->fmi;
    typed_array array;
    for (size_t i = 0; i < n; ++i) {
        if (kind == DS_REAL) {
            array.reals[i] = value[i];
        } else if (kind == DS_INTEGER) {
            array.integers[i] = (fmi2Integer)value[i];
        } else {
            array.booleans[i] = value[i] != 0.0;
        }
    }
    switch (kind) {
    case DS_REAL:
        return fmi->SetReal(c, vr, n, null ? NULL : array.reals);
    case DS_INTEGER:
        return fmi->SetInteger(c, vr, n, null ? NULL : array.integers);
    default:
        return fmi->SetBoolean(c, vr, n, null ? NULL : array.booleans);
    }
}

int subject_set(subject *s, ds_kind kind, const fmi2ValueReference vr[], size_t n, const double value[],
                null_argument null)
{
    const int sound = is_well_formed(s, SETTABLE, vr, n, kind, null) && are_settable(s, vr, n);
    const int allowed = !sound ? ALLOW_ERROR : are_in_range(vr, n, value) ? ALLOW_OK : ALLOW_DISCARD;
    const fmi2Component c = begin(s, SETTERS[kind], null);
    const fmi2Status status = set_typed(s, c, kind, null == NULL_REFERENCES ? NULL : vr, n, value,
                                        null == NULL_VALUES);
    if (!judge_end(s, status, allowed)) {
        return 0;
    }
    for (size_t i = 0; i < n; ++i) {
        s->known.value[vr[i]] = kind == DS_BOOLEAN ? value[i] != 0.0 : value[i];
    }
    s->known.unread = s->known.unread || n > 0;
    return 1;
}

int subject_set_texts(subject *s, const fmi2ValueReference vr[], size_t n, const fmi2String value[], null_argument null)
{
    const int sound = is_well_formed(s, SETTABLE, vr, n, DS_STRING, null) && are_settable(s, vr, n);
    int allowed = sound ? ALLOW_OK : ALLOW_ERROR;
    for (size_t i = 0; sound && i < n; ++i) {
        if (value[i] == NULL || strlen(value[i]) >= DS_TEXT_SIZE) {
            allowed = ALLOW_DISCARD | ALLOW_ERROR;
        }
    }
    const fmi2Component c = begin(s, SETTERS[DS_STRING], null);
    const fmi2Status status =
        s->run->fmi.SetString(c, null == NULL_REFERENCES ? NULL : vr, n,
                              null == NULL_VALUES ? NULL : value);
    if (!judge_end(s, status, allowed)) {
        return 0;
    }
    for (size_t i = 0; i < n; ++i) {
        snprintf(s->known.text[(int)ds_variables[vr[i]].start], DS_TEXT_SIZE, "%s", value[i]);
    }
    s->known.unread = s->known.unread || n > 0;
    return 1;
}

void subject_set_slopes(subject *s, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                        const double value[], null_argument null)
{
    const int sound = is_well_formed(s, SETTABLE, vr, n, DS_REAL, null);
    int allowed = sound ? ALLOW_OK : ALLOW_ERROR;
    for (size_t i = 0; sound && i < n; ++i) {
        if (ds_variables[vr[i]].role != DS_INPUT || order[i] != 1) {
            allowed = ALLOW_ERROR | ALLOW_DISCARD;
        }
    }
    for (size_t i = 0; allowed == ALLOW_OK && i < n; ++i) {
        if (!isfinite(value[i])) {
            allowed = ALLOW_DISCARD;
        }
    }
    const fmi2Component c = begin(s, "fmi2SetRealInputDerivatives", null);
    const fmi2Status status = s->run->fmi.SetRealInputDerivatives(
        c, null == NULL_REFERENCES ? NULL : vr, n, null == NULL_ORDERS ? NULL : order,
        null == NULL_VALUES ? NULL : value);
    if (judge_end(s, status, allowed)) {
        s->known.ramped = s->known.ramped || n > 0;
    }
}

/* hold what was read against what is known, or come to know it */
static void recognise(subject *s, fmi2ValueReference vr, double value)
{
    const ds_variable *const variable = &ds_variables[vr];
    const int settled = variable->role != DS_OUTPUT || s->known.phase == TERMINATED;
    session_see_number(s->run, value);
    if (variable->kind == DS_STRING) {
        return;
    }
    REQUIRE(s->run, !settled || memcmp(&value, &s->known.value[vr], sizeof value) == 0, "%s is %.17g, not %.17g",
            variable->name, value, s->known.value[vr]);
    s->known.value[vr] = value;
}

static void recognise_text(subject *s, fmi2ValueReference vr, fmi2String text)
{
    const char *const known = s->known.text[(int)ds_variables[vr].start];
    session_see_text(s->run, text);
    REQUIRE(s->run, strcmp(text, known) == 0, "%s is \"%s\", not \"%s\"", ds_variables[vr].name, text, known);
}

static double number_in(const typed_array *array, ds_kind kind, size_t i)
{
    return kind == DS_REAL ? array->reals[i] : kind == DS_INTEGER ? array->integers[i] : array->booleans[i];
}

static fmi2Status get_typed(const subject *s, fmi2Component c, ds_kind kind, const fmi2ValueReference *vr, size_t n,
                            typed_array *array)
{
    const fmi_functions *const fmi = &s->run->fmi;
    switch (kind) {
    case DS_REAL:
        return fmi->GetReal(c, vr, n, array == NULL ? NULL : array->reals);
    case DS_INTEGER:
        return fmi->GetInteger(c, vr, n, array == NULL ? NULL : array->integers);
    case DS_BOOLEAN:
        return fmi->GetBoolean(c, vr, n, array == NULL ? NULL : array->booleans);
    default:
        return fmi->GetString(c, vr, n, array == NULL ? NULL : array->texts);
    }
}

void subject_get(subject *s, ds_kind kind, const fmi2ValueReference vr[], size_t n, null_argument null)
{
    const int sound = is_well_formed(s, INITIALIZATION | STEPPING | TERMINATED, vr, n, kind, null);
    /* in initialization mode the parameters may contradict each other; after setting, 4.2.4 does not allow reading */
    const int maybe = s->known.phase == INITIALIZATION || s->known.unread;
    typed_array array;
    const fmi2Component c = begin(s, GETTERS[kind], null);
    const fmi2Status status = get_typed(s, c, kind, null == NULL_REFERENCES ? NULL : vr, n,
                                        null == NULL_VALUES ? NULL : &array);
    const int allowed = !sound ? ALLOW_ERROR : maybe ? ALLOW_OK | ALLOW_ERROR : ALLOW_OK;
    const int accepted = end_of_reading(s, status, allowed);
    for (size_t i = 0; accepted && i < n; ++i) {
        if (kind == DS_STRING) {
            recognise_text(s, vr[i], array.texts[i]);
        } else {
            recognise(s, vr[i], number_in(&array, kind, i));
        }
    }
}

void subject_read(subject *s)
{
    for (int kind = DS_REAL; kind <= DS_STRING; ++kind) {
        fmi2ValueReference vr[DS_VARIABLES];
        size_t n = 0;
        for (int i = 0; i < DS_VARIABLES; ++i) {
            if (ds_variables[i].kind == (ds_kind)kind) {
                vr[n++] = (fmi2ValueReference)i;
            }
        }
        subject_get(s, (ds_kind)kind, vr, n, NONE_NULL);
    }
}

void subject_get_slopes(subject *s, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                        null_argument null)
{
    double value[MOST];
    int allowed = is_well_formed(s, STEPPING | TERMINATED, vr, n, DS_REAL, null) ? ALLOW_OK : ALLOW_ERROR;
    for (size_t i = 0; allowed == ALLOW_OK && i < n; ++i) {
        if (ds_variables[vr[i]].role != DS_OUTPUT || order[i] != 1) {
            allowed = ALLOW_ERROR | ALLOW_DISCARD;
        }
    }
    const fmi2Component c = begin(s, "fmi2GetRealOutputDerivatives", null);
    const fmi2Status status = s->run->fmi.GetRealOutputDerivatives(
        c, null == NULL_REFERENCES ? NULL : vr, n, null == NULL_ORDERS ? NULL : order,
        null == NULL_VALUES ? NULL : value);
    if (judge_end_of_reading(s, status, s->known.unread && allowed == ALLOW_OK ? ALLOW_OK | ALLOW_ERROR : allowed)) {
        for (size_t i = 0; i < n; ++i) {
            session_see_number(s->run, value[i]);
            REQUIRE(s->run, isfinite(value[i]), "the derivative of %s is %g", ds_variables[vr[i]].name, value[i]);
        }
    }
}

void subject_get_sensitivities(subject *s, const fmi2ValueReference unknown[], size_t unknowns,
                               const fmi2ValueReference known[], size_t knowns, const double seed[], int null_seed)
{
    double value[MOST];
    const int there = s->component != NULL && !null_seed;
    judge_begin(s, "fmi2GetDirectionalDerivative");
    const fmi2Status status = s->run->fmi.GetDirectionalDerivative(s->component, unknown, unknowns, known, knowns,
                                                                   null_seed ? NULL : seed, value);
    if (end_of_reading(s, status, there ? ALLOW_OK | ALLOW_DISCARD | ALLOW_ERROR : ALLOW_ERROR)) {
        for (size_t i = 0; i < unknowns; ++i) {
            session_see_number(s->run, value[i]);
            REQUIRE(s->run, isfinite(value[i]), "a directional derivative is %g", value[i]);
        }
    }
}
