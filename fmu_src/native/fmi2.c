/* The life of an instance: creation, initialisation, steps, end. FMI 2.0.4, sections 2.1 and 4.2. */
#include "fmi2Functions.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ds_number.h"
#include "fmi2_instance.h"

#define ANY_PHASE (PHASE_INSTANTIATED | PHASE_INITIALIZATION | PHASE_STEP | PHASE_TERMINATED)
#define WHITE_SPACE " \t\r\n\v\f"

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

/* refuse an instantiation with a sentence */
static fmi2Component refuse(const fmi2CallbackFunctions *functions, const char *name, const char *sentence)
{
    if (functions != NULL && functions->logger != NULL) {
        functions->logger(functions->componentEnvironment, name, fmi2Error, "logStatusError", "%s", sentence);
    }
    return NULL;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging_on)
{
    (void)resources;
    (void)visible;
    if (name == NULL || name[strspn(name, WHITE_SPACE)] == '\0') {
        return refuse(functions, "?", "fmi2Instantiate needs an instance name");
    }
    if (functions == NULL) {
        return NULL;
    }
    if (type != fmi2CoSimulation) {
        return refuse(functions, name, DS_MODEL " is for co-simulation only");
    }
    if (guid == NULL || strcmp(guid, DS_GUID) != 0) {
        return refuse(functions, name, "the GUID is not that of this binary, " DS_GUID);
    }
    ds_instance *const instance = calloc(1, sizeof *instance);
    char *const copy = malloc(strlen(name) + 1);
    if (instance == NULL || copy == NULL) {
        free(instance);
        free(copy);
        return refuse(functions, name, "no memory for an instance");
    }
    instance->name = strcpy(copy, name);
    instance->callbacks = *functions;
    instance->journal.owner = instance;
    ds_switch_logging(instance, LOG_ALL, logging_on != fmi2False);
    ds_switch_logging(instance, LOG_DISCARD, 1);
    ds_switch_logging(instance, LOG_ERROR, 1);
    ds_instance_defaults(instance);
    return instance;
}

void fmi2FreeInstance(fmi2Component c)
{
    ds_instance *const instance = c;
    if (instance != NULL) {
        free(instance->memory);
        free(instance->name);
        free(instance);
    }
}

/* the log category of a name, LOG_ALL + 1 if there is none */
static int category_named(const char *name)
{
    int category = 0;
    while (category <= LOG_ALL && (name == NULL || strcmp(name, ds_log_categories[category]) != 0)) {
        ++category;
    }
    return category;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    ds_instance *const instance = c;
    if (!ds_legal(instance, "fmi2SetDebugLogging", ANY_PHASE)) {
        return fmi2Error;
    }
    if (n > 0 && categories == NULL) {
        return ds_tell(instance, fmi2Error, LOG_ERROR, "fmi2SetDebugLogging is called with a null pointer");
    }
    for (size_t i = 0; i < n; ++i) {
        if (category_named(categories[i]) > LOG_ALL) {
            return ds_tell(instance, fmi2Error, LOG_ERROR, "fmi2SetDebugLogging: there is no log category \"%s\"",
                           categories[i] == NULL ? "" : categories[i]);
        }
    }
    if (n == 0) {
        ds_switch_logging(instance, LOG_ALL, on != fmi2False);
    }
    for (size_t i = 0; i < n; ++i) {
        ds_switch_logging(instance, category_named(categories[i]), on != fmi2False);
    }
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start_time,
                               fmi2Boolean stop_time_defined, fmi2Real stop_time)
{
    ds_instance *const instance = c;
    (void)tolerance_defined;
    (void)tolerance;
    if (!ds_legal(instance, "fmi2SetupExperiment", PHASE_INSTANTIATED)) {
        return fmi2Error;
    }
    if (!isfinite(start_time)) {
        return ds_tell(instance, fmi2Error, LOG_ERROR, "start time is %.17g s; expected a finite value", start_time);
    }
    if (stop_time_defined && !(stop_time > start_time)) {
        return ds_tell(instance, fmi2Error, LOG_ERROR, "stop time is %.17g s; expected it after the start time %.17g s",
                       stop_time, start_time);
    }
    instance->now.time = start_time;
    instance->now.stale = 1;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    ds_instance *const instance = c;
    if (!ds_legal(instance, "fmi2EnterInitializationMode", PHASE_INSTANTIATED)) {
        return fmi2Error;
    }
    instance->now.phase = PHASE_INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    ds_instance *const instance = c;
    if (!ds_legal(instance, "fmi2ExitInitializationMode", PHASE_INITIALIZATION)) {
        return fmi2Error;
    }
    const fmi2Status status = ds_refresh(instance);
    if (status == fmi2OK) {
        instance->now.phase = PHASE_STEP;
    }
    return status;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    ds_instance *const instance = c;
    if (!ds_legal(instance, "fmi2Terminate", PHASE_STEP)) {
        return fmi2Error;
    }
    instance->now.phase = PHASE_TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    ds_instance *const instance = c;
    if (!ds_legal(instance, "fmi2Reset", ANY_PHASE)) {
        return fmi2Error;
    }
    ds_instance_defaults(instance);
    return fmi2OK;
}

/* whether a step from a communication point can be begun; says why not */
static int step_fits(const ds_instance *instance, double point, double step)
{
    const double time = instance->now.time;
    if (!(step > 0.0) || !isfinite(step)) {
        const ds_number_text given = ds_number(step);
        ds_tell(instance, fmi2Discard, LOG_DISCARD, "step size is %s s; expected a finite value > 0", given.text);
        return 0;
    }
    /* importers that add up their step size drift from t0 + k h by rounding */
    if (!(fabs(point - time) <= 1e-9 * fmax(1.0, fabs(time)) + 1e-6 * step)) {
        const ds_number_text given = ds_number(point);
        const ds_number_text own = ds_number(time);
        ds_tell(instance, fmi2Discard, LOG_DISCARD, "communication point is %s s; expected %s s", given.text, own.text);
        return 0;
    }
    if (!(point + step > time)) {
        const ds_number_text given = ds_number(step);
        ds_tell(instance, fmi2Discard, LOG_DISCARD, "step size is %s s; too small to be told from rounding", given.text);
        return 0;
    }
    return 1;
}

/* whether inputs that have a derivative stay in their range up to the end of the step; says which does not */
static int inputs_stay(const ds_instance *instance, double step)
{
    for (int i = 0; i < DS_VARIABLES; ++i) {
        const ds_variable *const variable = &ds_variables[i];
        const double slope = instance->now.slope[i];
        const double end = instance->now.value[i] + slope * step;
        if (slope != 0.0 && !(end >= variable->minimum && end <= variable->maximum)) {
            ds_tell(instance, fmi2Discard, LOG_DISCARD,
                    "%s comes to %.9g %s at the end of the step by its derivative %.9g; expected a value in [%.9g, %.9g]",
                    variable->name, end, variable->unit, slope, variable->minimum, variable->maximum);
            return 0;
        }
    }
    return 1;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real point, fmi2Real step, fmi2Boolean no_set_state_prior)
{
    ds_instance *const instance = c;
    (void)no_set_state_prior;
    if (!ds_legal(instance, "fmi2DoStep", PHASE_STEP)) {
        return fmi2Error;
    }
    ds_values *const now = &instance->now;
    ds_journal *const journal = &instance->journal;
    if (!step_fits(instance, point, step) || (now->sloped && !inputs_stay(instance, point + step - now->time))) {
        return fmi2Discard;
    }
    journal->reason[0] = '\0';
    ds_result result = ds_model_check(now->value, journal);
    if (result == DS_OK) {
        result = ds_model_step(instance->memory, now->value, now->slope, now->time, point + step, journal);
    }
    if (result != DS_OK) {
        return ds_tell(instance, fmi2Discard, LOG_DISCARD, "%s", journal->reason);
    }
    now->time = point + step;
    if (now->sloped) {
        memset(now->slope, 0, sizeof now->slope);
        now->sloped = 0;
    }
    return fmi2OK;
}
