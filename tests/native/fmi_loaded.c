/* The functions of an FMU's library, loaded as an importer loads it. */
#include <stddef.h>
#include <string.h>

#include "fmi.h"

#if defined(_WIN32)
#include <windows.h>

static void *open_library(const char *path)
{
    return (void *)LoadLibraryA(path);
}

static void find(void *library, const char *name, void *function, size_t size)
{
    const FARPROC found = GetProcAddress((HMODULE)library, name);
    memcpy(function, &found, size);
}
#else
#include <dlfcn.h>

static void *open_library(const char *path)
{
    return dlopen(path, RTLD_NOW | RTLD_LOCAL);
}

static void find(void *library, const char *name, void *function, size_t size)
{
    void *const found = dlsym(library, name);
    memcpy(function, &found, size);
}
#endif

const char *fmi_bind(fmi_functions *fmi, const char *library)
{
    void *const loaded = library == NULL ? NULL : open_library(library);
    const char *missing = NULL;
    if (loaded == NULL) {
        return "the library";
    }
#define FROM_LIBRARY(name) \
    find(loaded, "fmi2" #name, &fmi->name, sizeof fmi->name); \
    missing = fmi->name == NULL ? "fmi2" #name : missing;
    EACH_FUNCTION(FROM_LIBRARY)
#undef FROM_LIBRARY
    return missing;
}
