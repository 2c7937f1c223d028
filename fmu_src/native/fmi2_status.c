/* The state of a step that is still under way, FMI 2.0.4, sections 4.2.2 and 4.2.3. No step ever is: fmi2DoStep returns
 * when it is done. */
#include "fmi2Functions.h"
#include "fmi2_instance.h"

fmi2Status fmi2CancelStep(fmi2Component c)
{
    ds_instance *const instance = c;
    if (instance == NULL) {
        return fmi2Error;
    }
    return ds_tell(instance, fmi2Error, LOG_ERROR, "fmi2CancelStep is not allowed: no step is ever pending");
}

/* whether the status can be asked for; says so if not */
static int askable(const ds_instance *instance, const char *call, const void *value)
{
    if (!ds_legal(instance, call, PHASE_STEP | PHASE_TERMINATED)) {
        return 0;
    }
    if (value == NULL) {
        ds_tell(instance, fmi2Error, LOG_ERROR, "%s is called with a null pointer", call);
        return 0;
    }
    return 1;
}

/* the answer to a question that has none; FMI 2.0.4 wants fmi2Discard for it */
static fmi2Status unknown_status(const ds_instance *instance, const char *call)
{
    return ds_tell(instance, fmi2Discard, LOG_DISCARD, "%s: there is no such status, as no step is ever pending", call);
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind;
    return askable(c, "fmi2GetStatus", value) ? unknown_status(c, "fmi2GetStatus") : fmi2Error;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    const ds_instance *const instance = c;
    if (!askable(instance, "fmi2GetRealStatus", value)) {
        return fmi2Error;
    }
    if (kind != fmi2LastSuccessfulTime) {
        return unknown_status(instance, "fmi2GetRealStatus");
    }
    *value = instance->now.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind;
    return askable(c, "fmi2GetIntegerStatus", value) ? unknown_status(c, "fmi2GetIntegerStatus") : fmi2Error;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    if (!askable(c, "fmi2GetBooleanStatus", value)) {
        return fmi2Error;
    }
    if (kind != fmi2Terminated) {
        return unknown_status(c, "fmi2GetBooleanStatus");
    }
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind;
    return askable(c, "fmi2GetStringStatus", value) ? unknown_status(c, "fmi2GetStringStatus") : fmi2Error;
}
