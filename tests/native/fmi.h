/* The functions of one FMU, whether it is linked into the driver or loaded from its library. */
#ifndef FMI_H
#define FMI_H

#include "fmi2FunctionTypes.h"

#define EACH_FUNCTION(X) \
    X(GetTypesPlatform) X(GetVersion) X(SetDebugLogging) X(Instantiate) X(FreeInstance) X(SetupExperiment) \
    X(EnterInitializationMode) X(ExitInitializationMode) X(Terminate) X(Reset) X(GetReal) X(GetInteger) \
    X(GetBoolean) X(GetString) X(SetReal) X(SetInteger) X(SetBoolean) X(SetString) X(GetFMUstate) X(SetFMUstate) \
    X(FreeFMUstate) X(SerializedFMUstateSize) X(SerializeFMUstate) X(DeSerializeFMUstate) \
    X(GetDirectionalDerivative) X(SetRealInputDerivatives) X(GetRealOutputDerivatives) X(DoStep) X(CancelStep) \
    X(GetStatus) X(GetRealStatus) X(GetIntegerStatus) X(GetBooleanStatus) X(GetStringStatus)

typedef struct {
#define AS_POINTER(name) fmi2##name##TYPE *name;
    EACH_FUNCTION(AS_POINTER)
#undef AS_POINTER
} fmi_functions;

/* fill in the functions of a library, which is ignored where the FMU is linked in; returns what is missing or NULL */
const char *fmi_bind(fmi_functions *fmi, const char *library);

#endif
