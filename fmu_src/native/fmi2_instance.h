/* An instance of the FMU as the adapter keeps it: its phase, its values, and the memory of its model. */
#ifndef FMI2_INSTANCE_H
#define FMI2_INSTANCE_H

#include <stdint.h>

#include "ds_linkage.h"
#include "ds_model.h"
#include "ds_table.h"
#include "fmi2FunctionTypes.h"

/* the states of FMI 2.0.4, figure 11, that this FMU can be in; bits, so that a call can name those it is legal in */
typedef enum {
    PHASE_INSTANTIATED = 1,
    PHASE_INITIALIZATION = 2,
    PHASE_STEP = 4,
    PHASE_TERMINATED = 8
} ds_phase;

/* states in which variables can be read, and those in which inputs and parameters can be set */
#define DS_READABLE (PHASE_INITIALIZATION | PHASE_STEP | PHASE_TERMINATED)
#define DS_WRITABLE (PHASE_INSTANTIATED | PHASE_INITIALIZATION | PHASE_STEP)

/* everything that changes in time beside the memory of the model; flat, so that saving it is a copy */
typedef struct {
    int phase;                    /* ds_phase */
    int stale;                    /* parameters or inputs have changed since the model was started */
    int sloped;                   /* derivatives of inputs have been set since the last step */
    double time;                  /* s, communication point reached */
    double value[DS_VARIABLES];   /* one number per variable */
    double slope[DS_VARIABLES];   /* derivatives of inputs, valid for the next step */
    ds_text text[DS_TEXTS + 1];   /* String variables; one more, so that it is never empty */
} ds_values;

typedef struct {
    char *name;
    fmi2CallbackFunctions callbacks;
    int logging[DS_LOG_CATEGORIES]; /* categories that are switched on */
    ds_values now;
    void *memory;       /* of the model, and behind it as many bytes for what a step keeps */
    size_t memory_size; /* bytes, of the model alone */
    ds_journal journal;
} ds_instance;

/* the log categories, in the order of the table */
enum { LOG_EVENTS, LOG_WARNING, LOG_DISCARD, LOG_ERROR, LOG_ALL };

/* switch a category of messages on or off, LOG_ALL all of them */
DS_SHARED void ds_switch_logging(ds_instance *instance, int category, int on);
/* log a message with a status and give the status back; errors are logged whatever is switched off */
DS_SHARED fmi2Status ds_tell(const ds_instance *instance, fmi2Status status, int category, const char *format, ...);
DS_SHARED void ds_instance_defaults(ds_instance *instance);
/* whether a call is legal in the present phase; says so if not */
DS_SHARED int ds_legal(const ds_instance *instance, const char *call, int phases);
/* whether arrays and value references are sound and of one kind; says so if not */
DS_SHARED int ds_sound(const ds_instance *instance, const char *call, const fmi2ValueReference vr[], size_t n,
                       const void *values, ds_kind kind);
/* start the model if parameters or inputs have changed since; for the initialization mode */
DS_SHARED fmi2Status ds_refresh(ds_instance *instance);

#endif
