/* A run of calls: what it is called in reports, how far it has come, and the bits it has seen. */
#ifndef SESSION_H
#define SESSION_H

#include <stdint.h>
#include <stdio.h>

#include "fmi.h"

typedef struct {
    fmi_functions fmi;
    const char *table;   /* path of a CSV file that may be written, for the FMUs that read one */
    char name[64];       /* of the sequence under way, as it is repeated: "seed 17" */
    const char *call;    /* of FMI, under way */
    unsigned long calls; /* made, of the sequence and not for the checks of it */
    long starve;         /* 1, which allocation of the FMU from here on fails; 0: none */
    FILE *out;           /* where every number seen is written; NULL: nowhere */
    uint64_t digest;     /* FNV-1a of all seen */
} session;

void session_begin(session *run, const char *name, unsigned long number);
/* say what law is broken in which sequence and call, and end the process */
void session_fail(const session *run, const char *format, ...);

void session_see_text(session *run, const char *text);
/* the bits of a number, so that it is compared exactly */
void session_see_number(session *run, double value);
void session_see_bytes(session *run, const void *bytes, size_t n);

#define REQUIRE(run, condition, ...) \
    do { \
        if (!(condition)) { \
            session_fail((run), __VA_ARGS__); \
        } \
    } while (0)

#endif
