#include "session.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

void session_begin(session *run, const char *name, unsigned long number)
{
    snprintf(run->name, sizeof run->name, "%s %lu", name, number);
    run->call = "nothing yet";
    run->calls = 0;
    run->starve = 0;
    run->digest = 14695981039346656037u;
}

void session_fail(const session *run, const char *format, ...)
{
    va_list arguments;
    fprintf(stderr, "%s, call %lu, %s: ", run->name, run->calls, run->call);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    fflush(stderr);
    abort();
}

void session_see_bytes(session *run, const void *bytes, size_t n)
{
    const unsigned char *const byte = bytes;
    for (size_t i = 0; i < n; ++i) {
        run->digest = (run->digest ^ byte[i]) * 1099511628211u;
    }
}

void session_see_text(session *run, const char *text)
{
    session_see_bytes(run, text, strlen(text));
    if (run->out != NULL) {
        fprintf(run->out, "%s\n", text);
    }
}

void session_see_number(session *run, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    session_see_bytes(run, &bits, sizeof bits);
    if (run->out != NULL) {
        fprintf(run->out, "%016" PRIx64 "\n", bits);
    }
}
