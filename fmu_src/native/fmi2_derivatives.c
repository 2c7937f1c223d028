/* Derivatives of inputs and outputs by time, FMI 2.0.4, section 4.2.1, and of outputs by inputs, section 2.1.9. */
#include <math.h>

#include "ds_number.h"
#include "fmi2Functions.h"
#include "fmi2_instance.h"

/* whether only first derivatives are meant; says so if not */
static int orders_fit(const ds_instance *instance, const char *call, const fmi2ValueReference vr[], size_t n,
                      const fmi2Integer order[])
{
    if (n > 0 && order == NULL) {
        ds_tell(instance, fmi2Error, LOG_ERROR, "%s is called with a null pointer", call);
        return 0;
    }
    for (size_t i = 0; i < n; ++i) {
        if (order[i] != 1) {
            ds_tell(instance, fmi2Error, LOG_ERROR, "%s: the order for %s is %d; expected 1", call,
                    ds_variables[vr[i]].name, order[i]);
            return 0;
        }
    }
    return 1;
}

/* whether all variables have one role; says which has not */
static int all_are(const ds_instance *instance, const char *call, const fmi2ValueReference vr[], size_t n, ds_role role)
{
    for (size_t i = 0; i < n; ++i) {
        if (ds_variables[vr[i]].role != role) {
            ds_tell(instance, fmi2Error, LOG_ERROR, "%s: %s is no %s", call, ds_variables[vr[i]].name,
                    role == DS_INPUT ? "input" : "output");
            return 0;
        }
    }
    return 1;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    static const char *const call = "fmi2SetRealInputDerivatives";
    ds_instance *const instance = c;
    if (!ds_legal(instance, call, DS_WRITABLE) || !ds_sound(instance, call, vr, nvr, value, DS_REAL) ||
        !all_are(instance, call, vr, nvr, DS_INPUT) || !orders_fit(instance, call, vr, nvr, order)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < nvr; ++i) {
        if (!isfinite(value[i])) {
            const ds_number_text given = ds_number(value[i]);
            return ds_tell(instance, fmi2Discard, LOG_DISCARD,
                           "the derivative of %s is %s; expected a finite value", ds_variables[vr[i]].name, given.text);
        }
    }
    for (size_t i = 0; i < nvr; ++i) {
        instance->now.slope[vr[i]] = value[i];
    }
    instance->now.sloped = 1;
    if (instance->now.phase != PHASE_STEP) {
        instance->now.stale = 1;
    }
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[])
{
    static const char *const call = "fmi2GetRealOutputDerivatives";
    ds_instance *const instance = c;
    double rate[DS_VARIABLES] = {0.0};
    if (!ds_legal(instance, call, PHASE_STEP | PHASE_TERMINATED) ||
        !ds_sound(instance, call, vr, nvr, value, DS_REAL) || !all_are(instance, call, vr, nvr, DS_OUTPUT) ||
        !orders_fit(instance, call, vr, nvr, order)) {
        return fmi2Error;
    }
    ds_model_output_derivatives(instance->memory, rate);
    for (size_t i = 0; i < nvr; ++i) {
        value[i] = rate[vr[i]];
    }
    return fmi2OK;
}

/* whether derivatives by the variables can be had: by inputs, and by parameters as long as they can be set */
static int can_be_known(const ds_instance *instance, const char *call, const fmi2ValueReference vr[], size_t n)
{
    const int starting = instance->now.phase == PHASE_INITIALIZATION;
    for (size_t i = 0; i < n; ++i) {
        const ds_variable *const variable = &ds_variables[vr[i]];
        if (variable->role == DS_OUTPUT || (variable->role != DS_INPUT && !starting)) {
            ds_tell(instance, fmi2Error, LOG_ERROR, "%s: %s is no input%s", call, variable->name,
                    starting ? " and no parameter" : "");
            return 0;
        }
    }
    return 1;
}

/* whether the seeds can be had: a known that is not Real, as an enumeration that an output depends on, has none but 0 */
static int seeds_fit(const ds_instance *instance, const char *call, const fmi2ValueReference vr[], size_t n,
                     const fmi2Real seed[])
{
    if (n > 0 && (vr == NULL || seed == NULL)) {
        return ds_sound(instance, call, vr, n, seed, DS_REAL);
    }
    for (size_t i = 0; i < n; ++i) {
        const int still = vr[i] < DS_VARIABLES && ds_variables[vr[i]].kind != DS_REAL && seed[i] == 0.0;
        if (!still && !ds_sound(instance, call, &vr[i], 1, &seed[i], DS_REAL)) {
            return 0;
        }
    }
    return 1;
}

/* fill in the changes of all outputs and hand out those asked for; an infinite one is refused */
static fmi2Status hand_out_changes(ds_instance *instance, const char *call, const double seed[],
                                   const fmi2ValueReference vr[], size_t n, fmi2Real sensitivity[])
{
    double change[DS_VARIABLES] = {0.0};
#if DS_PROVIDES_DIRECTIONAL_DERIVATIVE
    const ds_values *const now = &instance->now;
    ds_model_directional_derivatives(instance->memory, now->value, seed, now->phase == PHASE_INITIALIZATION, change);
#else
    (void)seed;
#endif
    for (size_t i = 0; i < n; ++i) {
        if (!isfinite(change[vr[i]])) {
            return ds_tell(instance, fmi2Error, LOG_ERROR, "%s: %s has no finite derivative in that direction", call,
                           ds_variables[vr[i]].name);
        }
    }
    for (size_t i = 0; i < n; ++i) {
        sensitivity[i] = change[vr[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real seed[],
                                        fmi2Real sensitivity[])
{
    static const char *const call = "fmi2GetDirectionalDerivative";
    ds_instance *const instance = c;
    double seeds[DS_VARIABLES] = {0.0};
    if (!ds_legal(instance, call, DS_READABLE) ||
        !ds_sound(instance, call, unknown, n_unknown, sensitivity, DS_REAL) ||
        !seeds_fit(instance, call, known, n_known, seed) ||
        !all_are(instance, call, unknown, n_unknown, DS_OUTPUT) || !can_be_known(instance, call, known, n_known)) {
        return fmi2Error;
    }
    if (!DS_PROVIDES_DIRECTIONAL_DERIVATIVE) {
        return ds_tell(instance, fmi2Error, LOG_ERROR, "%s is not provided: " DS_MODEL " has no inputs", call);
    }
    for (size_t i = 0; i < n_known; ++i) {
        seeds[known[i]] += seed[i];
    }
    if (instance->now.phase == PHASE_INITIALIZATION) {
        const fmi2Status status = ds_refresh(instance);
        if (status != fmi2OK) {
            return status;
        }
    }
    return hand_out_changes(instance, call, seeds, unknown, n_unknown, sensitivity);
}
