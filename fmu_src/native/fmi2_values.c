/* Getting and setting variables: every argument is checked before anything is changed. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "ds_number.h"
#include "fmi2Functions.h"
#include "fmi2_instance.h"

#define READABLE (PHASE_INITIALIZATION | PHASE_STEP | PHASE_TERMINATED)
#define WRITABLE (PHASE_INSTANTIATED | PHASE_INITIALIZATION | PHASE_STEP)

static const char *const KINDS[] = {"Real", "Integer", "Boolean", "String"};

/* whether arrays and value references are sound and of one kind */
static int sound(const ds_instance *instance, const char *call, const fmi2ValueReference vr[], size_t n,
                 const void *values, ds_kind kind)
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
                    KINDS[ds_variables[vr[i]].kind]);
            return 0;
        }
    }
    return 1;
}

/* whether values can be read; outputs are brought up to date in initialization mode */
static fmi2Status ready_to_read(ds_instance *instance, const char *call, const fmi2ValueReference vr[], size_t n,
                                const void *values, ds_kind kind)
{
    if (!ds_legal(instance, call, READABLE) || !sound(instance, call, vr, n, values, kind)) {
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
    return ds_legal(instance, call, WRITABLE) && sound(instance, call, vr, n, values, kind) &&
           settable(instance, call, vr, n);
}

/* whether a value lies in the range of its variable; NaN does not */
static int in_range(const ds_instance *instance, const ds_variable *variable, double value)
{
    if (value >= variable->minimum && value <= variable->maximum) {
        return 1;
    }
    const ds_number_text shown = ds_number(value);
    const int bare = strcmp(variable->unit, "1") == 0;
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

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    ds_instance *const instance = c;
    const fmi2Status status = ready_to_read(instance, "fmi2GetReal", vr, nvr, value, DS_REAL);
    for (size_t i = 0; status == fmi2OK && i < nvr; ++i) {
        value[i] = instance->now.value[vr[i]];
    }
    return status;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[])
{
    ds_instance *const instance = c;
    const fmi2Status status = ready_to_read(instance, "fmi2GetInteger", vr, nvr, value, DS_INTEGER);
    for (size_t i = 0; status == fmi2OK && i < nvr; ++i) {
        value[i] = (fmi2Integer)instance->now.value[vr[i]];
    }
    return status;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[])
{
    ds_instance *const instance = c;
    const fmi2Status status = ready_to_read(instance, "fmi2GetBoolean", vr, nvr, value, DS_BOOLEAN);
    for (size_t i = 0; status == fmi2OK && i < nvr; ++i) {
        value[i] = instance->now.value[vr[i]] != 0.0 ? fmi2True : fmi2False;
    }
    return status;
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
    ds_instance *const instance = c;
    if (!admits(instance, "fmi2SetReal", vr, nvr, value, DS_REAL)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < nvr; ++i) {
        if (!in_range(instance, &ds_variables[vr[i]], value[i])) {
            return fmi2Discard;
        }
    }
    for (size_t i = 0; i < nvr; ++i) {
        assign(instance, vr[i], value[i]);
    }
    return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[])
{
    ds_instance *const instance = c;
    if (!admits(instance, "fmi2SetInteger", vr, nvr, value, DS_INTEGER)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < nvr; ++i) {
        if (!in_range(instance, &ds_variables[vr[i]], value[i])) {
            return fmi2Discard;
        }
    }
    for (size_t i = 0; i < nvr; ++i) {
        assign(instance, vr[i], value[i]);
    }
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[])
{
    ds_instance *const instance = c;
    if (!admits(instance, "fmi2SetBoolean", vr, nvr, value, DS_BOOLEAN)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < nvr; ++i) {
        assign(instance, vr[i], value[i] != fmi2False ? 1.0 : 0.0);
    }
    return fmi2OK;
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

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    static const char *const call = "fmi2SetRealInputDerivatives";
    ds_instance *const instance = c;
    if (!ds_legal(instance, call, WRITABLE) || !sound(instance, call, vr, nvr, value, DS_REAL)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < nvr; ++i) {
        const ds_variable *const variable = &ds_variables[vr[i]];
        if (!DS_CAN_INTERPOLATE_INPUTS || variable->role != DS_INPUT || order == NULL || order[i] != 1) {
            return ds_tell(instance, fmi2Error, LOG_ERROR, "%s: %s has no derivative of that order that could be set",
                           call, variable->name);
        }
        if (!isfinite(value[i])) {
            return ds_tell(instance, fmi2Discard, LOG_DISCARD, "the derivative of %s is %.17g; expected a finite value",
                           variable->name, value[i]);
        }
    }
    for (size_t i = 0; i < nvr; ++i) {
        instance->now.slope[vr[i]] = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[])
{
    static const char *const call = "fmi2GetRealOutputDerivatives";
    ds_instance *const instance = c;
    if (!ds_legal(instance, call, PHASE_STEP | PHASE_TERMINATED) ||
        !sound(instance, call, vr, nvr, value, DS_REAL)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < nvr; ++i) {
        if (ds_variables[vr[i]].role != DS_OUTPUT || order == NULL || order[i] < 1 ||
            order[i] > DS_OUTPUT_DERIVATIVE_ORDER) {
            return ds_tell(instance, fmi2Error, LOG_ERROR, "%s: %s has no derivative of that order", call,
                           ds_variables[vr[i]].name);
        }
    }
#if DS_OUTPUT_DERIVATIVE_ORDER > 0
    for (size_t i = 0; i < nvr; ++i) {
        value[i] = ds_model_output_derivative(instance->memory, instance->now.value, instance->now.time, (int)vr[i]);
    }
#endif
    return fmi2OK;
}
