#include "judge.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "allocation.h"

static int is_category(const char *name)
{
    for (int i = 0; i < DS_LOG_CATEGORIES; ++i) {
        if (strcmp(name, ds_log_categories[i]) == 0) {
            return 1;
        }
    }
    return 0;
}

void judge_logger(fmi2ComponentEnvironment owner, fmi2String name, fmi2Status status, fmi2String category,
                  fmi2String message, ...)
{
    subject *const s = owner;
    char text[2048];
    va_list arguments;
    va_start(arguments, message);
    const int length = vsnprintf(text, sizeof text, message, arguments);
    va_end(arguments);
    REQUIRE(s->run, length > 0 && (size_t)length < sizeof text, "a message of %d bytes", length);
    REQUIRE(s->run, name != NULL && (s->component == NULL || strcmp(name, s->name) == 0),
            "a message of %s comes from %s", s->name, name == NULL ? "nobody" : name);
    REQUIRE(s->run, category != NULL && is_category(category), "no log category: %s", category);
    REQUIRE(s->run, status >= fmi2OK && status <= fmi2Error, "a message with status %d", (int)status);
    s->told |= 1 << status;
    session_see_text(s->run, text);
}

void judge_take_image(subject *s, image *taken)
{
    const fmi_functions *const fmi = &s->run->fmi;
    size_t size = 0;
    int bad = fmi->GetFMUstate(s->component, &s->shadow) != fmi2OK;
    bad = bad || fmi->SerializedFMUstateSize(s->component, s->shadow, &size) != fmi2OK;
    if (!bad && size > taken->room) {
        taken->bytes = realloc(taken->bytes, size);
        taken->room = size;
        bad = taken->bytes == NULL;
    }
    bad = bad || fmi->SerializeFMUstate(s->component, s->shadow, taken->bytes, size) != fmi2OK;
    REQUIRE(s->run, !bad, "the state cannot be serialised");
    taken->size = size;
}

void judge_begin(subject *s, const char *call)
{
    session *const run = s->run;
    run->call = call;
    run->calls += 1;
    if (s->watched && s->component != NULL && !s->fresh) {
        judge_take_image(s, &s->before);
        s->fresh = 1;
    }
    s->told = 0;
    s->addressed = s->component;
    allocation_fail(run->starve);
}

static void require_unchanged(subject *s)
{
    if (s->watched && s->component != NULL) {
        judge_take_image(s, &s->after);
        REQUIRE(s->run, s->before.size == s->after.size && memcmp(s->before.bytes, s->after.bytes, s->after.size) == 0,
                "the call should have left the instance alone");
    }
}

/* whether the call was accepted */
static int judge(subject *s, fmi2Status status, int allowed)
{
    const long left = allocation_fail(0);
    const int starved = left == 0 && s->run->starve > 0;
    s->run->starve = left;
    session_see_number(s->run, (double)status);
    REQUIRE(s->run, (unsigned)status <= fmi2Pending && ((1 << status) & (starved ? ALLOW_ERROR : allowed)) != 0,
            "status %d%s", (int)status, starved ? " though an allocation failed" : "");
    if (status < fmi2Discard) {
        return 1;
    }
    const int heard = s->addressed != NULL && s->callbacks.logger != NULL && (status > fmi2Discard || s->discards_told);
    REQUIRE(s->run, !heard || (s->told & 1 << status) != 0, "status %d without a message that says why", (int)status);
    require_unchanged(s);
    return 0;
}

int judge_end(subject *s, fmi2Status status, int allowed)
{
    const int accepted = judge(s, status, allowed);
    if (accepted) {
        s->fresh = 0;
    }
    return accepted;
}

int judge_end_of_reading(subject *s, fmi2Status status, int allowed)
{
    const int accepted = judge(s, status, allowed);
    if (accepted) {
        require_unchanged(s);
    }
    return accepted;
}
