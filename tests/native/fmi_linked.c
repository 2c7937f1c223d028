/* The functions of the FMU that is linked into the driver. */
#include "fmi.h"
#include "fmi2Functions.h"

const char *fmi_bind(fmi_functions *fmi, const char *library)
{
    (void)library;
#define FROM_LINKER(name) fmi->name = fmi2##name;
    EACH_FUNCTION(FROM_LINKER)
#undef FROM_LINKER
    return NULL;
}
