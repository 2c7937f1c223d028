/* Couples four FMUs that are linked into this program, their functions told apart by FMI2_FUNCTION_PREFIX. */
#include <stdio.h>
#include <stdlib.h>

#include "fmi2FunctionTypes.h"
#include "references.h"

#define FUNCTIONS(model)                                                                                              \
    fmi2InstantiateTYPE model##_fmi2Instantiate;                                                                      \
    fmi2SetupExperimentTYPE model##_fmi2SetupExperiment;                                                              \
    fmi2EnterInitializationModeTYPE model##_fmi2EnterInitializationMode;                                              \
    fmi2ExitInitializationModeTYPE model##_fmi2ExitInitializationMode;                                                \
    fmi2SetRealTYPE model##_fmi2SetReal;                                                                              \
    fmi2SetIntegerTYPE model##_fmi2SetInteger;                                                                        \
    fmi2GetRealTYPE model##_fmi2GetReal;                                                                              \
    fmi2DoStepTYPE model##_fmi2DoStep;                                                                                \
    fmi2TerminateTYPE model##_fmi2Terminate;                                                                          \
    fmi2FreeInstanceTYPE model##_fmi2FreeInstance;                                                                    \
    static const fmi2String model##_guid = GUID_##model;                                                              \
    static fmi2Component model

FUNCTIONS(DrillingProgram);
FUNCTIONS(DrillstringNeutral);
FUNCTIONS(DissipativeLaw);
FUNCTIONS(WeightOnBitLaw);

static void must(fmi2Status status, const char *what)
{
    if (status != fmi2OK) {
        fprintf(stderr, "%s: status %d\n", what, (int)status);
        exit(1);
    }
}

static void report(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...)
{
    (void)environment;
    (void)category;
    fprintf(stderr, "%s (%d): %s\n", name, (int)status, message);
}

static const fmi2CallbackFunctions callbacks = {report, calloc, free, NULL, NULL};

#define OPEN(model)                                                                                                   \
    do {                                                                                                              \
        model = model##_fmi2Instantiate(#model, fmi2CoSimulation, model##_guid, "", &callbacks, fmi2False, fmi2False); \
        if (model == NULL) {                                                                                          \
            exit(1);                                                                                                  \
        }                                                                                                             \
        must(model##_fmi2SetupExperiment(model, fmi2False, 0.0, 0.0, fmi2False, 0.0), #model);                        \
    } while (0)

#define INITIALIZE(model)                                                                                             \
    do {                                                                                                              \
        must(model##_fmi2EnterInitializationMode(model), #model);                                                     \
        must(model##_fmi2ExitInitializationMode(model), #model);                                                      \
    } while (0)

#define CLOSE(model)                                                                                                  \
    do {                                                                                                              \
        must(model##_fmi2Terminate(model), #model);                                                                   \
        model##_fmi2FreeInstance(model);                                                                              \
    } while (0)

#define CONNECT(source, output, sink, input)                                                                          \
    do {                                                                                                              \
        const fmi2ValueReference from = source##_##output;                                                            \
        const fmi2ValueReference to = sink##_##input;                                                                 \
        fmi2Real value;                                                                                               \
        must(source##_fmi2GetReal(source, &from, 1, &value), #source "." #output);                                    \
        must(sink##_fmi2SetReal(sink, &to, 1, &value), #sink "." #input);                                             \
    } while (0)

static void connect(void)
{
    CONNECT(DrillingProgram, bit_speed_ref, DissipativeLaw, bit_speed_ref);
    CONNECT(DrillingProgram, bit_torque_ref, DissipativeLaw, bit_torque_ref);
    CONNECT(DrillstringNeutral, top_speed, DissipativeLaw, top_speed);
    CONNECT(DrillstringNeutral, bit_speed, DissipativeLaw, bit_speed);
    CONNECT(DrillstringNeutral, bit_speed, WeightOnBitLaw, bit_speed);
    CONNECT(DissipativeLaw, Omega, DrillstringNeutral, Omega);
    CONNECT(WeightOnBitLaw, WOB, DrillstringNeutral, WOB);
}

int main(void)
{
    const double step = 0.001;
    const fmi2ValueReference form = DissipativeLaw_form;
    const fmi2ValueReference speed = DrillstringNeutral_bit_speed;
    const fmi2Integer tracking = 2;
    OPEN(DrillingProgram);
    OPEN(DrillstringNeutral);
    OPEN(DissipativeLaw);
    OPEN(WeightOnBitLaw);
    must(DissipativeLaw_fmi2SetInteger(DissipativeLaw, &form, 1, &tracking), "form");
    INITIALIZE(DrillingProgram);
    INITIALIZE(DrillstringNeutral);
    INITIALIZE(DissipativeLaw);
    INITIALIZE(WeightOnBitLaw);
    for (int k = 0; k < 8000; ++k) {
        fmi2Real bit_speed;
        connect();
        must(DrillingProgram_fmi2DoStep(DrillingProgram, k * step, step, fmi2True), "DrillingProgram");
        must(DrillstringNeutral_fmi2DoStep(DrillstringNeutral, k * step, step, fmi2True), "DrillstringNeutral");
        must(DissipativeLaw_fmi2DoStep(DissipativeLaw, k * step, step, fmi2True), "DissipativeLaw");
        must(WeightOnBitLaw_fmi2DoStep(WeightOnBitLaw, k * step, step, fmi2True), "WeightOnBitLaw");
        must(DrillstringNeutral_fmi2GetReal(DrillstringNeutral, &speed, 1, &bit_speed), "bit_speed");
        printf("%.17g\n", bit_speed);
    }
    CLOSE(DrillingProgram);
    CLOSE(DrillstringNeutral);
    CLOSE(DissipativeLaw);
    CLOSE(WeightOnBitLaw);
    return 0;
}
