/* Saving, restoring and serialising the whole instance: one flat block with a header that tells what it is. */
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "fmi2_instance.h"

#define ANY_PHASE (PHASE_INSTANTIATED | PHASE_INITIALIZATION | PHASE_STEP | PHASE_TERMINATED)

#define GUID_SIZE 48 /* bytes of a GUID, filled up with zeros that count: a state with a flipped one is damaged */

static const char own_guid[GUID_SIZE] = DS_GUID;

typedef struct {
    char guid[GUID_SIZE]; /* of the FMU that wrote it */
    uint64_t size;        /* bytes, all of it */
    uint64_t memory_size; /* bytes, memory of the model */
    uint64_t checksum;    /* of everything after the header */
} header;

typedef struct {
    header head;
    ds_values values;
} saved_state;

/* FNV-1a: finds a flipped byte, is no protection against intent */
static uint64_t checksum_of(const unsigned char *bytes, size_t n)
{
    uint64_t sum = 14695981039346656037u;
    for (size_t i = 0; i < n; ++i) {
        sum = (sum ^ bytes[i]) * 1099511628211u;
    }
    return sum;
}

/* whether a state is one of this FMU; says so if not */
static int is_own(const ds_instance *instance, const char *call, const saved_state *saved)
{
    if (saved == NULL) {
        ds_tell(instance, fmi2Error, LOG_ERROR, "%s is called with a null pointer", call);
        return 0;
    }
    if (memcmp(saved->head.guid, own_guid, sizeof own_guid) != 0) {
        ds_tell(instance, fmi2Error, LOG_ERROR, "%s: the state is not one of this build of " DS_MODEL, call);
        return 0;
    }
    return 1;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    ds_instance *const instance = c;
    if (!ds_legal(instance, "fmi2GetFMUstate", ANY_PHASE)) {
        return fmi2Error;
    }
    if (state == NULL) {
        return ds_tell(instance, fmi2Error, LOG_ERROR, "fmi2GetFMUstate is called with a null pointer");
    }
    const size_t size = sizeof(saved_state) + instance->memory_size;
    saved_state *saved = *state;
    if (saved == NULL || saved->head.size != size) {
        saved = realloc(saved, size);
        if (saved == NULL) {
            return ds_tell(instance, fmi2Error, LOG_ERROR, "no memory for a state of %.0f bytes", (double)size);
        }
    }
    memset(&saved->head, 0, sizeof saved->head);
    memcpy(saved->head.guid, own_guid, sizeof own_guid);
    saved->head.size = size;
    saved->head.memory_size = instance->memory_size;
    saved->values = instance->now;
    if (instance->memory_size > 0) {
        memcpy(saved + 1, instance->memory, instance->memory_size);
    }
    *state = saved;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    ds_instance *const instance = c;
    const saved_state *const saved = state;
    if (!ds_legal(instance, "fmi2SetFMUstate", ANY_PHASE)) {
        return fmi2Error;
    }
    if (!is_own(instance, "fmi2SetFMUstate", saved)) {
        return fmi2Error;
    }
    const size_t memory_size = (size_t)saved->head.memory_size;
    if (memory_size != instance->memory_size) {
        void *const memory = memory_size > 0 ? malloc(2 * memory_size) : NULL;
        if (memory == NULL && memory_size > 0) {
            return ds_tell(instance, fmi2Error, LOG_ERROR, "no memory for a model of %.0f bytes", (double)memory_size);
        }
        free(instance->memory);
        instance->memory = memory;
        instance->memory_size = memory_size;
    }
    instance->now = saved->values;
    if (memory_size > 0) {
        memcpy(instance->memory, saved + 1, memory_size);
    }
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    if (c == NULL) {
        return fmi2Error;
    }
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    const saved_state *const saved = state;
    if (c == NULL || !is_own(c, "fmi2SerializedFMUstateSize", saved)) {
        return fmi2Error;
    }
    if (size == NULL) {
        return ds_tell(c, fmi2Error, LOG_ERROR, "fmi2SerializedFMUstateSize is called with a null pointer");
    }
    *size = (size_t)saved->head.size;
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    const saved_state *const saved = state;
    if (c == NULL || !is_own(c, "fmi2SerializeFMUstate", saved)) {
        return fmi2Error;
    }
    if (bytes == NULL || size < saved->head.size) {
        return ds_tell(c, fmi2Error, LOG_ERROR, "fmi2SerializeFMUstate is called with a null pointer or too few bytes");
    }
    const size_t rest = (size_t)saved->head.size - sizeof(header);
    header head = saved->head;
    head.checksum = checksum_of((const unsigned char *)saved + sizeof head, rest);
    memcpy(bytes, &head, sizeof head);
    memcpy(bytes + sizeof head, (const unsigned char *)saved + sizeof head, rest);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    ds_instance *const instance = c;
    header head;
    if (instance == NULL) {
        return fmi2Error;
    }
    if (bytes == NULL || state == NULL) {
        return ds_tell(instance, fmi2Error, LOG_ERROR, "fmi2DeSerializeFMUstate is called with a null pointer");
    }
    if (size < sizeof(saved_state)) {
        return ds_tell(instance, fmi2Error, LOG_ERROR, "the serialised state is cut off: it has %.0f bytes",
                       (double)size);
    }
    memcpy(&head, bytes, sizeof head);
    if (memcmp(head.guid, own_guid, sizeof own_guid) != 0) {
        return ds_tell(instance, fmi2Error, LOG_ERROR, "the serialised state is not one of this build of " DS_MODEL);
    }
    if (head.size != size || head.memory_size != size - sizeof(saved_state) ||
        head.checksum != checksum_of((const unsigned char *)bytes + sizeof head, size - sizeof head)) {
        return ds_tell(instance, fmi2Error, LOG_ERROR, "the serialised state is damaged: size or checksum do not fit");
    }
    saved_state *const saved = malloc(size);
    if (saved == NULL) {
        return ds_tell(instance, fmi2Error, LOG_ERROR, "no memory for a state of %.0f bytes", (double)size);
    }
    memcpy(saved, bytes, size);
    free(*state);
    *state = saved;
    return fmi2OK;
}
