/* An instance of the FMU under test together with what must be true of it. Every function here makes one FMI call (or
 * does what an importer does in a few), legal or not, and ends the process with a report unless
 *   - the status is one that the state machine of FMI 2.0.4, section 4.2.4, and the arguments allow,
 *   - a refusal says why to the logger and leaves the instance as it was, to the last bit,
 *   - what was set is read back, and the outputs obey their laws. */
#ifndef SUBJECT_H
#define SUBJECT_H

#include <stddef.h>

#include "ds_model.h"
#include "ds_table.h"
#include "session.h"

/* states of FMI 2.0.4, figure 11 */
typedef enum { INSTANTIATED = 1, INITIALIZATION = 2, STEPPING = 4, TERMINATED = 8 } phase;

#define ANY_TIME (INSTANTIATED | INITIALIZATION | STEPPING | TERMINATED)

/* what is known of an instance without asking it; part of every state that is saved */
typedef struct {
    int phase;
    int set_up;                 /* the experiment has been set up */
    int unread;                 /* something has been set since the last step: what is read is not defined */
    int ramped;                 /* inputs have derivatives for the next step */
    double start;               /* s */
    double time;                /* s */
    double value[DS_VARIABLES]; /* as it was set or last read */
    double energy;              /* J, at the start */
    double greatest;            /* J, greatest amount of energy seen, which errors are measured by */
    double rounding;            /* J, lost of work_in by rounding, at the most */
    ds_text text[DS_TEXTS + 1];
} knowledge;

/* a serialised state */
typedef struct {
    char *bytes;
    size_t size;
    size_t room;
} image;

typedef struct {
    session *run;
    fmi2Component component; /* NULL: not instantiated */
    fmi2Component addressed; /* by the call under way; NULL also where a call passes no instance on purpose */
    fmi2CallbackFunctions callbacks;
    char name[128];
    int watched;             /* its state is serialised round every call, to see that refusals leave it alone */
    int discards_told;       /* the log category of discards is on */
    int told;                /* statuses logged during the call under way, a bit each */
    knowledge known;
    image before;
    image after;
    int fresh;               /* `before` is the present state */
    fmi2FMUstate shadow;     /* state pointer used for `before` and `after` */
} subject;

typedef struct {
    fmi2FMUstate state;
    knowledge known;
} saved_state;

/* what is wrong with an instantiation on purpose */
typedef enum {
    SOUND,
    NO_NAME,
    EMPTY_NAME,
    MODEL_EXCHANGE,
    NO_GUID,
    OTHER_GUID,
    UNHEARD, /* another GUID, and no logger that could be told */
    NO_CALLBACKS,
    NOTHING, /* neither name nor callbacks */
    SILENT   /* none, but there is no logger */
} flaw;

/* which pointer of a call is null on purpose */
typedef enum { NONE_NULL, NULL_COMPONENT, NULL_REFERENCES, NULL_VALUES, NULL_ORDERS } null_argument;

void subject_instantiate(subject *s, session *run, const char *name, flaw what, int logging);
void subject_free(subject *s);
void subject_set_logging(subject *s, int on, size_t n, const fmi2String categories[]);
void subject_set_up(subject *s, double start, int stop_defined, double stop);
void subject_enter(subject *s);
int subject_exit(subject *s);
void subject_terminate(subject *s);
void subject_reset(subject *s);

/* set numbers of one kind; each must be representable in it */
int subject_set(subject *s, ds_kind kind, const fmi2ValueReference vr[], size_t n, const double value[],
                null_argument null);
int subject_set_texts(subject *s, const fmi2ValueReference vr[], size_t n, const fmi2String value[],
                      null_argument null);
void subject_set_slopes(subject *s, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                        const double value[], null_argument null);
void subject_get(subject *s, ds_kind kind, const fmi2ValueReference vr[], size_t n, null_argument null);
void subject_get_slopes(subject *s, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                        null_argument null);
void subject_get_sensitivities(subject *s, const fmi2ValueReference unknown[], size_t unknowns,
                               const fmi2ValueReference known[], size_t knowns, const double seed[], int null_seed);
/* read every variable and hold it against what is known and the laws */
void subject_read(subject *s);
int subject_step(subject *s, double point, double size);
void subject_cancel(subject *s);
void subject_ask_statuses(subject *s, fmi2StatusKind kind, int null);

void subject_save(subject *s, saved_state *slot);
void subject_restore(subject *s, const saved_state *slot);
void subject_forget(subject *s, saved_state *slot);
/* serialise a state and make another of the bytes, as another process does */
void subject_copy(subject *s, const saved_state *from, saved_state *to);
/* deserialise a state with one byte changed, or cut to a size; it must be refused and `to` stay as it is */
void subject_damage(subject *s, const saved_state *from, saved_state *to, size_t place, unsigned char change,
                    size_t size);
/* call what handles states with null pointers, and with a state that is none of the FMU's */
void subject_misuse_states(subject *s, const saved_state *slot);
/* step, go back, and step again to the same bits; the subject is stepping, and no allocation is to fail */
void subject_repeat(subject *s, double size);

/* number of a variable, -1 if the model has none of that name */
int variable_named(const char *name);
/* what is known of a variable of the model */
double subject_value(const subject *s, const char *name);
/* print what is known of it, for a report */
void subject_describe(const subject *s);

#endif
