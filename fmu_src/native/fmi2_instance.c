#include "fmi2_instance.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *phase_name(int phase)
{
    switch (phase) {
    case PHASE_INSTANTIATED:
        return "instantiated";
    case PHASE_INITIALIZATION:
        return "in initialization mode";
    case PHASE_STEP:
        return "stepping";
    default:
        return "terminated";
    }
}

fmi2Status ds_tell(const ds_instance *instance, fmi2Status status, int category, const char *format, ...)
{
    char text[DS_MESSAGE_SIZE];
    char message[DS_MESSAGE_SIZE + 128];
    va_list arguments;
    if (instance->callbacks.logger == NULL ||
        (status < fmi2Discard && !instance->logging[category] && !instance->logging[LOG_ALL])) {
        return status;
    }
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    snprintf(message, sizeof message, "%.64s at t = %.9g s: %s", instance->name, instance->now.time, text);
    instance->callbacks.logger(instance->callbacks.componentEnvironment, instance->name, status,
                               ds_log_categories[category], "%s", message);
    return status;
}

void ds_instance_defaults(ds_instance *instance)
{
    ds_values *const now = &instance->now;
    memset(now, 0, sizeof *now);
    now->phase = PHASE_INSTANTIATED;
    now->stale = 1;
    for (int i = 0; i < DS_VARIABLES; ++i) {
        now->value[i] = ds_variables[i].start;
    }
    free(instance->memory);
    instance->memory = NULL;
    instance->memory_size = 0;
}

int ds_legal(const ds_instance *instance, const char *call, int phases)
{
    if (instance == NULL) {
        return 0;
    }
    if ((instance->now.phase & phases) == 0) {
        ds_tell(instance, fmi2Error, LOG_ERROR, "%s is not allowed while the instance is %s", call,
                phase_name(instance->now.phase));
        return 0;
    }
    return 1;
}

fmi2Status ds_refresh(ds_instance *instance)
{
    ds_values *const now = &instance->now;
    ds_journal *const journal = &instance->journal;
    if (!now->stale) {
        return fmi2OK;
    }
    journal->reason[0] = '\0';
    if (ds_model_check(now->value, journal) != DS_OK) {
        return ds_tell(instance, fmi2Error, LOG_ERROR, "%s", journal->reason);
    }
    const size_t size = ds_model_size(now->value, (const ds_text *)now->text, journal);
    if (size == 0) {
        return ds_tell(instance, fmi2Error, LOG_ERROR, "%s", journal->reason);
    }
    if (size != instance->memory_size) {
        void *const memory = calloc(1, size);
        if (memory == NULL) {
            return ds_tell(instance, fmi2Error, LOG_ERROR, "no memory for a model of %.0f bytes", (double)size);
        }
        free(instance->memory);
        instance->memory = memory;
        instance->memory_size = size;
    }
    if (ds_model_start(instance->memory, size, now->value, (const ds_text *)now->text, now->time, journal) != DS_OK) {
        return ds_tell(instance, fmi2Error, LOG_ERROR, "%s", journal->reason);
    }
    now->stale = 0;
    return fmi2OK;
}
