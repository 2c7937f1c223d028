/* Getting and setting variables: every argument is checked before anything is changed. */
#include <stdio.h>
#include <string.h>

#include "ds_number.h"
#include "fmi2Functions.h"
#include "fmi2_instance.h"


int ds_sound(const ds_instance *instance, const char *call, const fmi2ValueReference vr[], size_t n, const void *values,
             ds_kind kind)
{
    if (n > 0 && (vr == NULL || values == NULL)) {
        ds_tell(instance, fmi2Error, LOG_ERROR, "%s is called with a null pointer", call);
        return 0;
    }
    for (size_t i = 0; i < n; ++i) {
        if (vr[i] >= DS_VARIABLES) {
            ds_tell(instance, fmi2Error, LOG_ERROR, "%s: there is no variable with value reference %u", call, vr[i]);
            return 0;
        }
        if (ds_variables[vr[i]].kind != kind) {
            ds_tell(instance, fmi2Error, LOG_ERROR, "%s: variable %s is of type %s", call, ds_variables[vr[i]].name,
                    ds_variables[vr[i]].type);
            return 0;
        }
    }
    return 1;
}

/* whether values can be read; outputs are brought up to date in initialization mode */
static fmi2Status ready_to_read(ds_instance *instance, const char *call, const fmi2ValueReference vr[], size_t n,
                                const void *values, ds_kind kind)
{
    if (!ds_legal(instance, call, DS_READABLE) || !ds_sound(instance, call, vr, n, values, kind)) {
        return fmi2Error;
    }
    return instance->now.phase == PHASE_INITIALIZATION ? ds_refresh(instance) : fmi2OK;
}

/* whether the variables can be set in the present phase */
static int settable(const ds_instance *instance, const char *call, const fmi2ValueReference vr[], size_t n)
{
    for (size_t i = 0; i < n; ++i) {
        const ds_variable *const variable = &ds_variables[vr[i]];
        if (variable->role == DS_OUTPUT) {
            ds_tell(instance, fmi2Error, LOG_ERROR, "%s: %s is an output and cannot be set", call, variable->name);
            return 0;
        }
        if (variable->role == DS_FIXED && instance->now.phase == PHASE_STEP) {
            ds_tell(instance, fmi2Error, LOG_ERROR, "%s: %s is a fixed parameter; it can be set before the start only",
                    call, variable->name);
            return 0;
        }
    }
    return 1;
}

/* whether variables of one kind can be set in the present phase; says why not */
static int admits(const ds_instance *instance, const char *call, const fmi2ValueReference vr[], size_t n,
                  const void *values, ds_kind kind)
{
    return ds_legal(instance, call, DS_WRITABLE) && ds_sound(instance, call, vr, n, values, kind) &&
           settable(instance, call, vr, n);
}

/* whether a value lies in the range of its variable; NaN does not */
static int in_range(const ds_instance *instance, const ds_variable *variable, double value)
{
    if (value >= variable->minimum && value <= variable->maximum) {
        return 1;
    }
    const ds_number_text shown = ds_number(value);
    const int bare = variable->unit[0] == '\0' || strcmp(variable->unit, "1") == 0;
    ds_tell(instance, fmi2Discard, LOG_DISCARD, "%s is %s%s%s; expected a finite value in [%.9g, %.9g]", variable->name,
            shown.text, bare ? "" : " ", bare ? "" : variable->unit, variable->minimum, variable->maximum);
    return 0;
}

static void assign(ds_instance *instance, fmi2ValueReference vr, double value)
{
    instance->now.value[vr] = value;
    if (instance->now.phase != PHASE_STEP) {
        instance->now.stale = 1;
    }
}

/* fmi2GetXXX of all types but String: Real values are an array of double, the others of int */
static fmi2Status get_numbers(ds_instance *instance, const char *call, ds_kind kind, const fmi2ValueReference vr[],
                              size_t n, void *values)
{
    const fmi2Status status = ready_to_read(instance, call, vr, n, values, kind);
    for (size_t i = 0; status == fmi2OK && i < n; ++i) {
        const double number = instance->now.value[vr[i]];
        if (kind == DS_REAL) {
            ((fmi2Real *)values)[i] = number;
        } else {
            ((fmi2Integer *)values)[i] = (fmi2Integer)number;
        }
    }
    return status;
}

/* one of the values given to fmi2SetXXX */
static double number_at(const void *values, size_t i, ds_kind kind)
{
    if (kind == DS_REAL) {
        return ((const fmi2Real *)values)[i];
    }
    const fmi2Integer number = ((const fmi2Integer *)values)[i];
    return kind == DS_BOOLEAN ? number != fmi2False : number;
}

/* fmi2SetXXX of all types but String: all values are set, or none */
static fmi2Status set_numbers(ds_instance *instance, const char *call, ds_kind kind, const fmi2ValueReference vr[],
                              size_t n, const void *values)
{
    if (!admits(instance, call, vr, n, values, kind)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < n; ++i) {
        if (!in_range(instance, &ds_variables[vr[i]], number_at(values, i, kind))) {
            return fmi2Discard;
        }
    }
    for (size_t i = 0; i < n; ++i) {
        assign(instance, vr[i], number_at(values, i, kind));
    }
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    return get_numbers(c, "fmi2GetReal", DS_REAL, vr, nvr, value);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[])
{
    return get_numbers(c, "fmi2GetInteger", DS_INTEGER, vr, nvr, value);
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[])
{
    return get_numbers(c, "fmi2GetBoolean", DS_BOOLEAN, vr, nvr, value);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[])
{
    ds_instance *const instance = c;
    const fmi2Status status = ready_to_read(instance, "fmi2GetString", vr, nvr, value, DS_STRING);
    for (size_t i = 0; status == fmi2OK && i < nvr; ++i) {
        value[i] = instance->now.text[(int)instance->now.value[vr[i]]];
    }
    return status;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[])
{
    return set_numbers(c, "fmi2SetReal", DS_REAL, vr, nvr, value);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[])
{
    return set_numbers(c, "fmi2SetInteger", DS_INTEGER, vr, nvr, value);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[])
{
    return set_numbers(c, "fmi2SetBoolean", DS_BOOLEAN, vr, nvr, value);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2String value[])
{
    ds_instance *const instance = c;
    if (!admits(instance, "fmi2SetString", vr, nvr, value, DS_STRING)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < nvr; ++i) {
        if (value[i] == NULL || strlen(value[i]) >= DS_TEXT_SIZE) {
            return ds_tell(instance, fmi2Discard, LOG_DISCARD, "%s is %s; expected a text of at most %d bytes",
                           ds_variables[vr[i]].name, value[i] == NULL ? "null" : "longer", DS_TEXT_SIZE - 1);
        }
    }
    for (size_t i = 0; i < nvr; ++i) {
        const int slot = (int)instance->now.value[vr[i]];
        snprintf(instance->now.text[slot], DS_TEXT_SIZE, "%s", value[i]);
        assign(instance, vr[i], slot);
    }
    return fmi2OK;
}
