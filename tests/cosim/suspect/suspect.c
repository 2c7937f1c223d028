/* An FMI 2.0 co-simulation FMU that keeps every promise, unless the file fault.txt in its resources names one to break.

   x' = gain u, w' = x, with the input linear within a step; y = x + w, z = gain u. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2Functions.h"
#ifdef _WIN32
#include <process.h>
#define getpid _getpid
#else
#include <unistd.h>
#endif

enum { VR_U, VR_GAIN, VR_Y, VR_Z, REALS };
enum { INSTANTIATED, INITIALIZATION, STEPPING, TERMINATED };

typedef struct {
    double real[REALS];
    double slope, x, w, time, last_u, last_slope;
    int steps, phase;
} State;

typedef struct {
    State state;
    int logging;
    char name[64], fault[32];
    const fmi2CallbackFunctions *functions;
} Suspect;

typedef struct {
    State state;
    int process;
    unsigned sum;
} Saved;

static double shared_w;

#define SELF Suspect *self = (Suspect *)c
#define FAULT(word) (strcmp(self->fault, word) == 0)

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

static void say(Suspect *self, fmi2Status status, const char *category, const char *text) {
    self->functions->logger(self->functions->componentEnvironment, self->name, status, category, text);
}
static fmi2Status refuse(Suspect *self, const char *why) {
    say(self, fmi2Error, "logStatusError", why);
    return fmi2Error;
}

static void fresh(Suspect *self) {
    double w = self->state.w;
    memset(&self->state, 0, sizeof self->state);
    self->state.real[VR_U] = 1.0;
    self->state.real[VR_GAIN] = FAULT("wrong start") ? 2.0 : 1.0;
    if (FAULT("half a reset")) self->state.w = w;
}
static double *hidden(Suspect *self) { return FAULT("shared state") ? &shared_w : &self->state.w; }

static void put_out(Suspect *self, double u) {
    State *s = &self->state;
    s->real[VR_Y] = s->x + *hidden(self);
    s->real[VR_Z] = s->real[VR_GAIN] * u;
    if (FAULT("wrong output")) s->real[VR_Y] *= 1.001;
    if (FAULT("not a number") && s->time > 0.5) s->real[VR_Y] = NAN;
}

static void read_fault(Suspect *self, const char *resources) {
    char path[4096];
    const char *begin = strstr(resources, "file://");
    snprintf(path, sizeof path, "%s/fault.txt", begin ? begin + strlen("file://") : resources);
    FILE *file = fopen(path, "r");
    if (file) {
        if (!fgets(self->fault, sizeof self->fault, file)) self->fault[0] = 0;
        fclose(file);
    }
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    (void)type; (void)visible;
    Suspect *self = calloc(1, sizeof *self);
    self->functions = functions;
    self->logging = logging;
    strncpy(self->name, name, sizeof self->name - 1);
    read_fault(self, resources);
    if ((strcmp(guid, "{suspect}") != 0 && !FAULT("any guid")) || FAULT("no instance")) {
        say(self, fmi2Error, "logStatusError", "not for you");
        free(self);
        return NULL;
    }
    fresh(self);
    return self;
}
void fmi2FreeInstance(fmi2Component c) {
    SELF;
    if (FAULT("crash when freed") && self->state.phase == TERMINATED) abort();
    free(self);
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real start, fmi2Boolean e, fmi2Real f) {
    SELF;
    (void)e; (void)f;
    if (FAULT("tolerance of 1e-4") && !(a && b == 1e-4)) return refuse(self, "another tolerance");
    if (FAULT("starts at 0 only") && start != 0.0) return refuse(self, "the start is not 0");
    if (FAULT("resets in the set-up")) fresh(self);
    self->state.time = start;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    SELF;
    if (self->state.phase != INSTANTIATED) return refuse(self, "not now");
    self->state.phase = INITIALIZATION;
    shared_w = 0.0;
    put_out(self, self->state.real[VR_U]);
    return fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    SELF;
    if (self->state.phase != INITIALIZATION) return refuse(self, "not now");
    self->state.phase = STEPPING;
    put_out(self, self->state.real[VR_U]);
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) {
    SELF;
    self->state.phase = TERMINATED;
    return fmi2OK;
}
#ifndef WITHOUT_RESET
fmi2Status fmi2Reset(fmi2Component c) {
    SELF;
    fresh(self);
    return fmi2OK;
}
#endif
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String names[]) {
    SELF;
    (void)n; (void)names;
    self->logging = on;
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    SELF;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] > VR_GAIN) return refuse(self, "unknown reference");
        double low = vr[i] == VR_GAIN ? 0.0 : -100.0, high = vr[i] == VR_GAIN ? 10.0 : 100.0;
        if (!(value[i] >= low && value[i] <= high) && !FAULT("any value")) return refuse(self, "out of bounds");
        self->state.real[vr[i]] = value[i];
        if (vr[i] == VR_U) self->state.slope = 0.0;
    }
    if (self->state.phase == INITIALIZATION) put_out(self, self->state.real[VR_U]);
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    SELF;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= REALS || (vr[i] == VR_Z && FAULT("unreadable"))) return refuse(self, "unknown reference");
        value[i] = self->state.real[vr[i]];
    }
    return fmi2OK;
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    SELF;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != 0) return refuse(self, "unknown reference");
        value[i] = self->state.steps;
    }
    return fmi2OK;
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    SELF; (void)vr;
    for (size_t i = 0; i < n; i++) value[i] = self->state.x > 1.0;
    return fmi2OK;
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    SELF; (void)vr;
    for (size_t i = 0; i < n; i++) value[i] = FAULT("null string") ? NULL : "suspect";
    return fmi2OK;
}

static void misbehave(Suspect *self, double t) {
    if (FAULT("undeclared category") && self->logging) say(self, fmi2OK, "logGossip", "have you heard");
    if (FAULT("chatter")) say(self, fmi2OK, "logEvents", "a step");
    if (FAULT("crash at gain 3") && self->state.real[VR_GAIN] == 3.0) abort();
    if (t < 0.5) return;
    if (FAULT("crash in a step")) abort();
    if (FAULT("end of the process")) exit(0);
    while (FAULT("hang in a step")) {}
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_rollback) {
    SELF;
    State *s = &self->state;
    (void)no_rollback;
    if (s->phase != STEPPING) return refuse(self, "not now");
    if (!(fabs(t - s->time) <= 1e-9 * fmax(1.0, fabs(t)))) return refuse(self, "another time");
    if (FAULT("exact times") && t < 2.0 && fabs(t - round(t / 0.005) * 0.005) > 3e-16) return refuse(self, "rounded time");
    if (FAULT("fixed step") && fabs(h - 0.01) > 1e-12) return refuse(self, "another step size");
    misbehave(self, t);
    s->time = t + h;
    if (FAULT("ignores the step size")) h = 0.01;
    double u = s->real[VR_U], slope = FAULT("ignores derivatives") ? 0.0 : s->slope, gain = s->real[VR_GAIN];
    *hidden(self) += h * (s->x + h * gain * (u / 2.0 + h * slope / 6.0));
    s->x += h * gain * (u + h * slope / 2.0);
    s->steps++;
    put_out(self, u + h * slope);
    s->last_u = u + h * slope;
    s->last_slope = slope;
    s->slope = 0.0;
    if (self->logging) say(self, fmi2OK, "logEvents", "100 % of a step");
    return fmi2OK;
}
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    SELF;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != VR_U || order[i] != 1) return refuse(self, "unknown derivative");
        self->state.slope = value[i];
    }
    return fmi2OK;
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[]) {
    SELF;
    State *s = &self->state;
    for (size_t i = 0; i < n; i++) {
        if ((vr[i] != VR_Y && vr[i] != VR_Z) || order[i] != 1) return refuse(self, "unknown derivative");
        value[i] = vr[i] == VR_Y ? s->x + s->real[VR_GAIN] * s->last_u : s->real[VR_GAIN] * s->last_slope;
        if (FAULT("wrong output derivative")) value[i] *= 1.5;
    }
    return fmi2OK;
}
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference u[], size_t nu,
                                        const fmi2ValueReference k[], size_t nk, const fmi2Real dk[], fmi2Real du[]) {
    SELF;
    for (size_t i = 0; i < nu; i++) {
        du[i] = 0.0;
        for (size_t j = 0; j < nk; j++)
            if (u[i] == VR_Z && k[j] == VR_U) du[i] += self->state.real[VR_GAIN] * dk[j];
        if (FAULT("wrong partial derivative")) du[i] *= 2.0;
        if (FAULT("partial derivative nan")) du[i] = NAN;
    }
    return fmi2OK;
}

static unsigned sum_of(const State *state) {
    unsigned sum = 2166136261u;
    for (size_t i = 0; i < sizeof *state; i++) sum = (sum ^ ((const unsigned char *)state)[i]) * 16777619u;
    return sum;
}
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    SELF;
    if (FAULT("crash when saved")) abort();
    if (FAULT("refuses states")) return refuse(self, "no states here");
    Saved *saved = calloc(1, sizeof *saved);
    saved->state = self->state;
    saved->state.w = *hidden(self);
    if (FAULT("forgetful state")) saved->state.w = 0.0;
    saved->process = (int)getpid();
    saved->sum = sum_of(&saved->state);
    *state = saved;
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    SELF;
    self->state = ((Saved *)state)->state;
    *hidden(self) = self->state.w;
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    SELF;
    (void)state;
    *size = sizeof(Saved);
    return FAULT("refuses states") ? refuse(self, "no states here") : fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    (void)c;
    memcpy(bytes, state, size);
    return fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    SELF;
    Saved *saved = malloc(sizeof *saved);
    if (size <= sizeof *saved) memcpy(saved, bytes, size);
    int good = size == sizeof *saved && saved->sum == sum_of(&saved->state);
    if (FAULT("crash when damaged") && !good) abort();
    if (FAULT("accepts damage")) good = 1;
    if (FAULT("one process only") && saved->process != (int)getpid()) good = 0;
    if (!good) {
        free(saved);
        return refuse(self, "not a state");
    }
    *state = saved;
    return fmi2OK;
}

#define UNUSED(name, ...) fmi2Status name(__VA_ARGS__) { return fmi2Error; }
UNUSED(fmi2SetInteger, fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer v[])
UNUSED(fmi2SetBoolean, fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean v[])
UNUSED(fmi2SetString, fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String v[])
UNUSED(fmi2CancelStep, fmi2Component c)
UNUSED(fmi2GetStatus, fmi2Component c, const fmi2StatusKind k, fmi2Status *v)
UNUSED(fmi2GetRealStatus, fmi2Component c, const fmi2StatusKind k, fmi2Real *v)
UNUSED(fmi2GetIntegerStatus, fmi2Component c, const fmi2StatusKind k, fmi2Integer *v)
UNUSED(fmi2GetBooleanStatus, fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v)
UNUSED(fmi2GetStringStatus, fmi2Component c, const fmi2StatusKind k, fmi2String *v)
