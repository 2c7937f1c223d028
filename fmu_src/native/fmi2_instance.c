#include "fmi2_instance.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LONGEST_NAME 64 /* bytes, in messages */

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

/* bytes of a name shown in messages; a character of UTF-8 is not cut apart */
static int shown_length(const char *name)
{
    int length = 0;
    while (length < LONGEST_NAME && name[length] != '\0') {
        ++length;
    }
    while (name[length] != '\0' && ((unsigned char)name[length] & 0xC0) == 0x80) {
        --length;
    }
    return length;
}

/* hand a sentence to the importer's logger, with instance and time before it */
static void hand_over(const ds_instance *instance, double time, fmi2Status status, int category, const char *sentence)
{
    char message[DS_MESSAGE_SIZE + 128];
    char escaped[2 * sizeof message];
    size_t length = 0;
    snprintf(message, sizeof message, "%.*s at t = %.9g s: %s", shown_length(instance->name), instance->name, time,
             sentence);
    /* FMI 2.0.4, section 2.1.5: a # by itself begins a reference to a variable */
    for (const char *from = message; *from != '\0'; ++from) {
        escaped[length++] = *from;
        if (*from == '#') {
            escaped[length++] = '#';
        }
    }
    escaped[length] = '\0';
    instance->callbacks.logger(instance->callbacks.componentEnvironment, instance->name, status,
                               ds_log_categories[category], "%s", escaped);
}

static void log_event(void *owner, double time, const char *sentence)
{
    hand_over(owner, time, fmi2OK, LOG_EVENTS, sentence);
}

static void log_warning(void *owner, double time, const char *sentence)
{
    hand_over(owner, time, fmi2Warning, LOG_WARNING, sentence);
}

void ds_switch_logging(ds_instance *instance, int category, int on)
{
    int *const logging = instance->logging;
    const int heard = instance->callbacks.logger != NULL;
    for (int i = 0; i < DS_LOG_CATEGORIES; ++i) {
        logging[i] = i == category || category == LOG_ALL ? on : logging[i];
    }
    instance->journal.event = heard && logging[LOG_EVENTS] ? log_event : NULL;
    instance->journal.warning = heard && logging[LOG_WARNING] ? log_warning : NULL;
}

fmi2Status ds_tell(const ds_instance *instance, fmi2Status status, int category, const char *format, ...)
{
    char sentence[DS_MESSAGE_SIZE];
    va_list arguments;
    if (instance->callbacks.logger != NULL && (status >= fmi2Error || instance->logging[category])) {
        va_start(arguments, format);
        vsnprintf(sentence, sizeof sentence, format, arguments);
        va_end(arguments);
        hand_over(instance, instance->now.time, status, category, sentence);
    }
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
    void *const memory = calloc(2, size);
    if (memory == NULL) {
        return ds_tell(instance, fmi2Error, LOG_ERROR, "no memory for a model of %.0f bytes", (double)size);
    }
    if (size == instance->memory_size) { /* a model may tell what has changed since it was started before */
        memcpy(memory, instance->memory, size);
    }
    if (ds_model_start(memory, size, now->value, now->slope, (const ds_text *)now->text, now->time, journal) != DS_OK) {
        free(memory);
        return ds_tell(instance, fmi2Error, LOG_ERROR, "%s", journal->reason);
    }
    free(instance->memory);
    instance->memory = memory;
    instance->memory_size = size;
    now->stale = 0;
    return fmi2OK;
}
