/* A minimal FMI 2.0 co-simulation FMU that shows what a master did to it.

   Its name makes it behave as FMUs out there do: "resetting" puts parameters back in fmi2SetupExperiment, "forgetful"
   loses one while it initialises, "tolerant" has as gain the tolerance it was told, or 9 if none, "dividing" has u = 4 and refuses u = 0, "offering" has u_seen = 5, "strict" refuses a step beyond its stop time by any bit,
   "forgetting" restores all of its state but the integral, "stateless" fails to restore any, "counting" counts all steps
   that it has ever taken, "ending" ends itself at fail_at, and "ending-mute" does so without telling when.

   With a fail_status from 10 on it misbehaves, in the function that its parameter text names, or in fmi2DoStep. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2Functions.h"

enum { VR_U, VR_V, VR_INTEGRAL, VR_U_SEEN, VR_FAIL_AT, VR_FAIL_STATUS, VR_GAIN, REALS };
enum { VR_N, VR_N_NEXT, VR_MODE, INTEGERS };
enum { VR_TEXT, VR_SAID, VR_HEARD, TEXTS };

typedef struct {
    const fmi2CallbackFunctions *functions;
    char name[64];
    double real[REALS];
    double u_dot;
    int integer[INTEGERS];
    int flag;
    char text[TEXTS][64];
    double time;
    double stop;
    int promised; /* not to go back */
    int ended;
} Probe;

#define SELF Probe *self = (Probe *)c

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

static void say(Probe *self, fmi2Status status, const char *format, double value) {
    self->functions->logger(self->functions->componentEnvironment, self->name, status, "logStatusError", format, value);
}

enum { SEGFAULT = 10, ABORT, EXIT, HANG, GROW, DEMAND, SHOUT };

static void misbehave(Probe *self, const char *place) {
    if (self->real[VR_FAIL_STATUS] < SEGFAULT || strcmp(self->text[VR_TEXT][0] ? self->text[VR_TEXT] : "step", place) != 0) return;
    switch ((int)self->real[VR_FAIL_STATUS]) {
    case SEGFAULT: signal(SIGSEGV, SIG_DFL); raise(SIGSEGV); break;
    case ABORT: abort();
    case EXIT: exit(3);
    case GROW:
        for (void *piece = malloc(1 << 20); piece; piece = malloc(1 << 20)) memset(piece, 1, 1 << 20);
        for (volatile int held = 1; held;) {}
    case HANG: for (volatile int hung = 1; hung;) {}
    case DEMAND: {
        void *volatile much = malloc((size_t)1 << 40);
        if (!much) say(self, fmi2Error, "there is no memory left at %g s", self->time);
        break;
    }
    case SHOUT: printf("the probe shouts\n"); fflush(stdout); break;
    default: break;
    }
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    (void)type; (void)resources; (void)visible; (void)logging;
    Probe *self = calloc(1, sizeof(Probe));
    self->functions = functions;
    strncpy(self->name, name, sizeof self->name - 1);
    if (strcmp(guid, "{probe}") != 0 || strcmp(name, "refused") == 0) {
        say(self, fmi2Error, "not this time, %g", 7.0);
        free(self);
        return NULL;
    }
    if (strcmp(name, "crashing") == 0) abort();
    self->real[VR_FAIL_AT] = 1e300;
    self->real[VR_FAIL_STATUS] = 2.0;
    self->real[VR_GAIN] = 1.0;
    self->integer[VR_MODE] = 1;
    if (strcmp(name, "dividing") == 0) self->real[VR_U] = 4.0;
    if (strcmp(name, "offering") == 0) self->real[VR_U_SEEN] = 5.0;
    return self;
}
void fmi2FreeInstance(fmi2Component c) {
    misbehave((Probe *)c, "free");
    free(c);
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real d, fmi2Boolean e, fmi2Real f) {
    SELF; (void)e;
    if (strcmp(self->name, "tolerant") == 0) self->real[VR_GAIN] = a ? b : 9.0;
    self->time = d;
    self->stop = f;
    if (strcmp(self->name, "resetting") == 0) {
        self->real[VR_GAIN] = 1.0;
        self->text[VR_TEXT][0] = 0;
    }
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    SELF;
    misbehave(self, "exit");
    if (strcmp(self->name, "forgetful") == 0) self->real[VR_GAIN] = 1.0;
    say(self, fmi2Warning, "ready at %g", 1.5);
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) {
    SELF;
    misbehave(self, "terminate");
    return fmi2OK;
}
fmi2Status fmi2Reset(fmi2Component c) { (void)c; return fmi2OK; }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String names[]) {
    (void)c; (void)on; (void)n; (void)names; return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    SELF;
    for (size_t i = 0; i < n; i++) if (vr[i] >= REALS) return fmi2Error; /* descriptions are mutated */
    for (size_t i = 0; i < n; i++) {
        if (value[i] != value[i]) {
            say(self, fmi2Discard, "input %g is nan", (double)vr[i]);
            return fmi2Discard;
        }
        if (vr[i] == VR_U && value[i] == 0.0 && strcmp(self->name, "dividing") == 0) {
            say(self, fmi2Error, "division by u = %g", value[i]);
            return fmi2Error;
        }
        self->real[vr[i]] = value[i];
        if (vr[i] == VR_U) misbehave(self, "set");
        if (vr[i] == VR_U) self->u_dot = 0.0;
    }
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    SELF;
    for (size_t i = 0; i < n; i++) if (vr[i] >= REALS) return fmi2Error; /* descriptions are mutated */
    misbehave(self, "get");
    for (size_t i = 0; i < n; i++) value[i] = self->real[vr[i]];
    return fmi2OK;
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    SELF;
    for (size_t i = 0; i < n; i++) if (vr[i] >= INTEGERS) return fmi2Error; /* descriptions are mutated */
    for (size_t i = 0; i < n; i++) self->integer[vr[i]] = value[i];
    return fmi2OK;
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    SELF;
    for (size_t i = 0; i < n; i++) if (vr[i] >= INTEGERS) return fmi2Error; /* descriptions are mutated */
    for (size_t i = 0; i < n; i++) value[i] = self->integer[vr[i]];
    return fmi2OK;
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    SELF; (void)vr;
    for (size_t i = 0; i < n; i++) self->flag = value[i];
    return fmi2OK;
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    SELF;
    for (size_t i = 0; i < n; i++) value[i] = vr[i] ? !self->flag : self->flag;
    return fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    SELF;
    for (size_t i = 0; i < n; i++) strncpy(self->text[vr[i]], value[i], sizeof self->text[0] - 1);
    return fmi2OK;
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    SELF;
    for (size_t i = 0; i < n; i++) value[i] = self->text[vr[i]];
    return fmi2OK;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    SELF; (void)vr;
    for (size_t i = 0; i < n; i++) if (order[i] == 1) self->u_dot = value[i];
    return fmi2OK;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_rollback) {
    SELF;
    if (strcmp(self->name, "strict") == 0 && t + h > self->stop) {
        say(self, fmi2Error, "a step beyond the stop time, by %g s", t + h - self->stop);
        return fmi2Error;
    }
    if (strncmp(self->name, "ending", 6) == 0 && t + h > self->real[VR_FAIL_AT] + 1e-9) {
        self->ended = 1;
        self->time = self->real[VR_FAIL_AT];
        say(self, fmi2Discard, "nothing is left to drill at %g s", self->time);
        return fmi2Discard;
    }
    if (t >= self->real[VR_FAIL_AT]) {
        misbehave(self, "step");
        fmi2Status status = self->real[VR_FAIL_STATUS] < SEGFAULT ? (fmi2Status)self->real[VR_FAIL_STATUS]
                            : self->real[VR_FAIL_STATUS] == DEMAND ? fmi2Error : fmi2OK;
        if (status == fmi2OK || self->real[VR_FAIL_STATUS] == DEMAND) return status;
        say(self, status, "the probe gave up at %g s", t);
        return status;
    }
    /* Exact for an input that is linear within the step. */
    self->real[VR_INTEGRAL] += self->real[VR_GAIN] * h * (self->real[VR_U] + 0.5 * h * self->u_dot);
    self->real[VR_U_SEEN] = self->real[VR_U] + h * self->u_dot;
    memcpy(self->text[VR_HEARD], self->text[VR_SAID], sizeof self->text[0]);
    self->integer[VR_N_NEXT] = self->integer[VR_N] + self->integer[VR_MODE];
    self->time = t + h;
    self->promised = no_rollback;
    if (strcmp(self->name, "counting") == 0) {
        static int steps = 0;
        self->integer[VR_N_NEXT] = ++steps;
    }
    return fmi2OK;
}

/* Remembers what it was promised, and holds the master to it. */
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *s) {
    SELF;
    if (*s == NULL) *s = malloc(sizeof(Probe));
    memcpy(*s, self, sizeof(Probe));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate s) {
    SELF;
    if (self->promised && ((Probe *)s)->time < self->time) {
        say(self, fmi2Error, "it was promised not to go back to %g s", ((Probe *)s)->time);
        return fmi2Error;
    }
    if (strcmp(self->name, "stateless") == 0) {
        say(self, fmi2Error, "there is no way back to %g s", ((Probe *)s)->time);
        return fmi2Error;
    }
    const double integral = self->real[VR_INTEGRAL];
    memcpy(self, s, sizeof(Probe));
    if (strcmp(self->name, "forgetting") == 0) self->real[VR_INTEGRAL] = integral;
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *s) {
    (void)c;
    free(*s);
    *s = NULL;
    return fmi2OK;
}

#define UNUSED(name, ...) fmi2Status name(__VA_ARGS__) { return fmi2Error; }
UNUSED(fmi2SerializedFMUstateSize, fmi2Component c, fmi2FMUstate s, size_t *n)
UNUSED(fmi2SerializeFMUstate, fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n)
UNUSED(fmi2DeSerializeFMUstate, fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
UNUSED(fmi2GetDirectionalDerivative, fmi2Component c, const fmi2ValueReference u[], size_t nu,
       const fmi2ValueReference k[], size_t nk, const fmi2Real d[], fmi2Real r[])
UNUSED(fmi2GetRealOutputDerivatives, fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer o[],
       fmi2Real v[])
UNUSED(fmi2CancelStep, fmi2Component c)
UNUSED(fmi2GetStatus, fmi2Component c, const fmi2StatusKind k, fmi2Status *v)
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *v) {
    SELF;
    if (k != fmi2LastSuccessfulTime || strcmp(self->name, "ending-mute") == 0) return fmi2Discard;
    *v = self->time;
    return fmi2OK;
}
UNUSED(fmi2GetIntegerStatus, fmi2Component c, const fmi2StatusKind k, fmi2Integer *v)
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v) {
    SELF;
    *v = k == fmi2Terminated && self->ended;
    return fmi2OK;
}
UNUSED(fmi2GetStringStatus, fmi2Component c, const fmi2StatusKind k, fmi2String *v)
