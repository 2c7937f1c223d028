/* The loops an importer written in C would run, and the bare kernel beside them, for `make bench`. */
#include <stdlib.h>

#include "ds_neutral.h"
#include "ds_table.h"
#include "fmi2FunctionTypes.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

enum { MOST = 64 };

/* one FMU as the importer holds it: its functions, and what to set and get in every step */
typedef struct {
    fmi2Component component;
    fmi2SetRealTYPE *set_real;
    fmi2DoStepTYPE *do_step;
    fmi2GetRealTYPE *get_real;
    fmi2GetIntegerTYPE *get_integer;
    fmi2GetBooleanTYPE *get_boolean;
    size_t reals, integers, booleans;
    fmi2ValueReference real[MOST], integer[MOST], boolean[MOST];
    fmi2ValueReference input;
} importer;

/* an output that is passed on to an input */
typedef struct {
    size_t source, target; /* numbers of FMUs */
    fmi2ValueReference output, input;
} connection;

/* an Omega that jumps by up to 0.5 rad/s every step */
static double jumping(long k)
{
    return 10.0 + 0.01 * (double)((k * 7919) % 101 - 50);
}

static int read_all(const importer *fmu)
{
    double reals[MOST];
    fmi2Integer integers[MOST];
    fmi2Boolean booleans[MOST];
    return fmu->get_real(fmu->component, fmu->real, fmu->reals, reals) > fmi2OK ||
           (fmu->integers > 0 && fmu->get_integer(fmu->component, fmu->integer, fmu->integers, integers) > fmi2OK) ||
           (fmu->booleans > 0 && fmu->get_boolean(fmu->component, fmu->boolean, fmu->booleans, booleans) > fmi2OK);
}

/* Fig. 2 by the bare kernel: outputs read at every communication point */
EXPORT double bench_kernel(double step, long steps, int cells)
{
    const ds_parameters p = {79.3e9, 1.19e-5, 0.095, 1172.0, 89.0, 2000.0, {0.155575, 1.0, 0.03, 0.5, 0.8, 0.9}};
    ds_neutral model;
    double outputs[DS_VARIABLES] = {0};
    ds_neutral_build(&model, &p, cells, 0.0);
    ds_neutral_state *const state = malloc(ds_neutral_state_size(model.blocks));
    ds_neutral_start(&model, state, 0.0, 0.0, 10.0, 97347.0);
    for (long k = 0; k < steps; ++k) {
        ds_neutral_advance(&model, state, (double)k * step + step);
        ds_neutral_read(&model, state, outputs);
    }
    free(state);
    return outputs[DS_bit_speed];
}

/* fmi2DoStep and nothing else; 0 if all calls succeed */
EXPORT int bench_do_step(const importer *fmu, double step, long steps)
{
    for (long k = 0; k < steps; ++k) {
        if (fmu->do_step(fmu->component, (double)k * step, step, fmi2True) > fmi2OK) {
            return 1;
        }
    }
    return 0;
}

/* steps of one FMU with every output read; 0 if all calls succeed. With `set`, the input is set before every step */
EXPORT int bench_fmu(const importer *fmu, double step, long steps, int set, int jump)
{
    for (long k = 0; k < steps; ++k) {
        const double omega = jump ? jumping(k) : 10.0;
        if (set && fmu->set_real(fmu->component, &fmu->input, 1, &omega) > fmi2OK) {
            return 1;
        }
        if (fmu->do_step(fmu->component, (double)k * step, step, fmi2True) > fmi2OK || read_all(fmu)) {
            return 1;
        }
    }
    return 0;
}

static int pass_on(const importer *const fmus[], const connection *c)
{
    double value;
    return fmus[c->source]->get_real(fmus[c->source]->component, &c->output, 1, &value) > fmi2OK ||
           fmus[c->target]->set_real(fmus[c->target]->component, &c->input, 1, &value) > fmi2OK;
}

/* FMUs coupled as the master does it (Jacobi), everything read and nothing recorded: the FMUs' own time */
EXPORT int bench_coupled(const importer *const fmus[], size_t count, const connection connections[],
                         size_t connection_count, double step, long steps)
{
    for (long k = 0; k < steps; ++k) {
        for (size_t i = 0; i < connection_count; ++i) {
            if (pass_on(fmus, &connections[i])) {
                return 1;
            }
        }
        for (size_t i = 0; i < count; ++i) {
            if (fmus[i]->do_step(fmus[i]->component, (double)k * step, step, fmi2True) > fmi2OK || read_all(fmus[i])) {
                return 1;
            }
        }
    }
    return 0;
}
