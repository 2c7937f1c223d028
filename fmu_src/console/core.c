/* A model for the console in the browser: the functions of ds_model.h with no FMI about them.
 * Built once for every model, behind all its sources: DS_EXPORTED puts the model's name before that of a function. Whoever
 * calls reads and writes `value` and `slope` in the memory of the module, at the address that `allocate` returns. */
#include <stdlib.h>
#include <string.h>

#include "ds_model.h"

typedef struct {
    double value[DS_VARIABLES]; /* by value reference */
    double slope[DS_VARIABLES]; /* derivatives of the inputs */
    ds_journal journal;
    size_t size;  /* bytes, of the model in `memory` */
    void *memory; /* of the model, and behind it as many bytes for what a step keeps */
} ds_console;

/* return an instance with its start values; null if there is no memory */
ds_console *DS_EXPORTED(allocate)(void)
{
    ds_console *const console = calloc(1, sizeof *console);
    for (int i = 0; console != NULL && i < DS_VARIABLES; ++i) {
        console->value[i] = ds_variables[i].kind == DS_STRING ? 0.0 : ds_variables[i].start;
    }
    return console;
}

void DS_EXPORTED(release)(ds_console *console)
{
    free(console->memory);
    free(console);
}

/* begin, or begin anew, with the values there are */
int DS_EXPORTED(start)(ds_console *console, double time)
{
    const size_t size = ds_model_size(console->value, NULL, &console->journal);
    if (size == 0 || ds_model_check(console->value, &console->journal) != DS_OK) {
        return DS_DISCARD;
    }
    if (size != console->size) {
        free(console->memory);
        console->memory = calloc(2, size);
        console->size = console->memory != NULL ? size : 0;
    }
    if (console->memory == NULL) {
        return DS_FAILED;
    }
    return (int)ds_model_start(console->memory, size, console->value, console->slope, NULL, time, &console->journal);
}

/* go to `end`, with parameters that may have been tuned; as in FMI, derivatives of inputs hold for one step */
int DS_EXPORTED(step)(ds_console *console, double time, double end)
{
    if (ds_model_check(console->value, &console->journal) != DS_OK) {
        return DS_DISCARD;
    }
    const ds_result result =
        ds_model_step(console->memory, console->value, console->slope, time, end, &console->journal);
    if (result == DS_OK) {
        memset(console->slope, 0, sizeof console->slope);
    }
    return (int)result;
}

/* the sentence that explains the last refusal */
const char *DS_EXPORTED(reason)(const ds_console *console)
{
    return console->journal.reason;
}
