/* Saving, restoring, serialising the state of a subject, and handing it damaged ones. */
#include <stdlib.h>
#include <string.h>

#include "judge.h"

void subject_save(subject *s, saved_state *slot)
{
    fmi2FMUstate *const state = slot == NULL ? NULL : &slot->state;
    judge_begin(s, "fmi2GetFMUstate");
    const fmi2Status status = s->run->fmi.GetFMUstate(s->component, state);
    const int sound = s->component != NULL && slot != NULL;
    if (judge_end_of_reading(s, status, sound ? ALLOW_OK : ALLOW_ERROR)) {
        slot->known = s->known;
    }
}

void subject_restore(subject *s, const saved_state *slot)
{
    judge_begin(s, "fmi2SetFMUstate");
    const fmi2Status status = s->run->fmi.SetFMUstate(s->component, slot->state);
    const int sound = s->component != NULL && slot->state != NULL;
    if (judge_end(s, status, sound ? ALLOW_OK : ALLOW_ERROR)) {
        s->known = slot->known;
    }
}

void subject_forget(subject *s, saved_state *slot)
{
    judge_begin(s, "fmi2FreeFMUstate");
    const fmi2Status status = s->run->fmi.FreeFMUstate(s->component, slot == NULL ? NULL : &slot->state);
    judge_end_of_reading(s, status, s->component != NULL ? ALLOW_OK : ALLOW_ERROR);
    REQUIRE(s->run, s->component == NULL || slot == NULL || slot->state == NULL, "a freed state is still pointed to");
}

/* serialise a state, which is there, into `taken` */
static int take(subject *s, const saved_state *from, image *taken)
{
    const fmi_functions *const fmi = &s->run->fmi;
    size_t size = 0;
    judge_begin(s, "fmi2SerializedFMUstateSize");
    fmi2Status status = fmi->SerializedFMUstateSize(s->component, from->state, &size);
    const int sound = s->component != NULL && from->state != NULL;
    if (!judge_end_of_reading(s, status, sound ? ALLOW_OK : ALLOW_ERROR)) {
        return 0;
    }
    taken->bytes = malloc(size);
    taken->size = size;
    REQUIRE(s->run, taken->bytes != NULL, "no memory for the driver");
    judge_begin(s, "fmi2SerializeFMUstate");
    status = fmi->SerializeFMUstate(s->component, from->state, taken->bytes, size - 1);
    judge_end_of_reading(s, status, ALLOW_ERROR);
    judge_begin(s, "fmi2SerializeFMUstate");
    status = fmi->SerializeFMUstate(s->component, from->state, taken->bytes, size);
    judge_end_of_reading(s, status, ALLOW_OK);
    session_see_bytes(s->run, taken->bytes, size);
    return 1;
}

void subject_copy(subject *s, const saved_state *from, saved_state *to)
{
    image taken;
    if (!take(s, from, &taken)) {
        return;
    }
    judge_begin(s, "fmi2DeSerializeFMUstate");
    const fmi2Status status = s->run->fmi.DeSerializeFMUstate(s->component, taken.bytes, taken.size, &to->state);
    if (judge_end_of_reading(s, status, ALLOW_OK)) {
        image again;
        to->known = from->known;
        take(s, to, &again);
        REQUIRE(s->run, again.size == taken.size && memcmp(again.bytes, taken.bytes, taken.size) == 0,
                "a state is not what it was made of");
        free(again.bytes);
    }
    free(taken.bytes);
}

void subject_damage(subject *s, const saved_state *from, saved_state *to, size_t place, unsigned char change,
                    size_t size)
{
    const fmi2FMUstate former = to->state;
    image taken;
    if (!take(s, from, &taken)) {
        return;
    }
    const size_t kept = size < taken.size ? size : taken.size - (change == 0);
    char *const bytes = malloc(kept == 0 ? 1 : kept); /* of its own size, so that reading beyond is seen */
    REQUIRE(s->run, bytes != NULL, "no memory for the driver");
    memcpy(bytes, taken.bytes, kept);
    if (kept > 0) {
        bytes[place % kept] = (char)(bytes[place % kept] ^ change);
    }
    judge_begin(s, "fmi2DeSerializeFMUstate");
    const fmi2Status status = s->run->fmi.DeSerializeFMUstate(s->component, bytes, kept, &to->state);
    judge_end_of_reading(s, status, ALLOW_ERROR);
    REQUIRE(s->run, to->state == former, "a refused state has been put in place");
    free(bytes);
    free(taken.bytes);
}

void subject_misuse_states(subject *s, const saved_state *slot)
{
    static char foreign[4096];
    const fmi_functions *const fmi = &s->run->fmi;
    fmi2FMUstate none = NULL;
    size_t size;
    char byte = 0;
    judge_begin(s, "fmi2SetFMUstate");
    judge_end_of_reading(s, fmi->SetFMUstate(s->component, foreign), ALLOW_ERROR);
    judge_begin(s, "fmi2SetFMUstate");
    judge_end_of_reading(s, fmi->SetFMUstate(s->component, NULL), ALLOW_ERROR);
    judge_begin(s, "fmi2SerializedFMUstateSize");
    judge_end_of_reading(s, fmi->SerializedFMUstateSize(s->component, slot->state, NULL), ALLOW_ERROR);
    judge_begin(s, "fmi2SerializedFMUstateSize");
    judge_end_of_reading(s, fmi->SerializedFMUstateSize(s->component, NULL, &size), ALLOW_ERROR);
    judge_begin(s, "fmi2SerializeFMUstate");
    judge_end_of_reading(s, fmi->SerializeFMUstate(s->component, slot->state, NULL, sizeof foreign), ALLOW_ERROR);
    judge_begin(s, "fmi2SerializeFMUstate");
    judge_end_of_reading(s, fmi->SerializeFMUstate(s->component, NULL, &byte, 1), ALLOW_ERROR);
    judge_begin(s, "fmi2DeSerializeFMUstate");
    judge_end_of_reading(s, fmi->DeSerializeFMUstate(s->component, NULL, sizeof foreign, &none), ALLOW_ERROR);
    judge_begin(s, "fmi2DeSerializeFMUstate");
    judge_end_of_reading(s, fmi->DeSerializeFMUstate(s->component, foreign, sizeof foreign, NULL), ALLOW_ERROR);
    judge_begin(s, "fmi2DeSerializeFMUstate");
    judge_end_of_reading(s, fmi->DeSerializeFMUstate(s->component, foreign, sizeof foreign, &none), ALLOW_ERROR);
}

void subject_repeat(subject *s, double size)
{
    saved_state begin = {NULL, {0}};
    saved_state first = {NULL, {0}};
    saved_state second = {NULL, {0}};
    image one;
    image other;
    subject_save(s, &begin);
    if (begin.state != NULL && subject_step(s, s->known.time, size)) {
        subject_save(s, &first);
        subject_restore(s, &begin);
        REQUIRE(s->run, subject_step(s, s->known.time, size), "a step is refused when it is repeated");
        subject_save(s, &second);
        take(s, &first, &one);
        take(s, &second, &other);
        REQUIRE(s->run, one.size == other.size && memcmp(one.bytes, other.bytes, one.size) == 0,
                "a step repeated from a saved state ends elsewhere");
        free(one.bytes);
        free(other.bytes);
        subject_forget(s, &first);
        subject_forget(s, &second);
    }
    subject_forget(s, &begin);
}
