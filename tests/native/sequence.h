/* Bytes as a sequence of calls, legal and illegal, on several instances at once: what random runs and fuzzing share. */
#ifndef SEQUENCE_H
#define SEQUENCE_H

#include <stddef.h>
#include <stdint.h>

#include "session.h"

/* make the calls that the bytes stand for, up to the end of the bytes, and free everything */
void sequence_run(session *run, const uint8_t *bytes, size_t n);

/* make the sequences of the seeds from one on until that many calls are made, a line to the report for each; returns
 * how many calls were made */
unsigned long sequence_run_seeds(session *run, unsigned long seed, unsigned long calls, FILE *report);

#endif
