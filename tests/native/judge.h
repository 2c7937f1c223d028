/* What comes before and after every FMI call on a subject: counting, watching, judging the status. */
#ifndef JUDGE_H
#define JUDGE_H

#include "subject.h"

enum {
    ALLOW_OK = 1 << fmi2OK | 1 << fmi2Warning,
    ALLOW_DISCARD = 1 << fmi2Discard,
    ALLOW_ERROR = 1 << fmi2Error
};

void judge_logger(fmi2ComponentEnvironment owner, fmi2String name, fmi2Status status, fmi2String category,
                  fmi2String message, ...);
void judge_begin(subject *s, const char *call);
/* whether the call was accepted; the process ends unless its status is allowed and a refusal changed nothing */
int judge_end(subject *s, fmi2Status status, int allowed);
/* the same of a call that must not change anything even if it is accepted */
int judge_end_of_reading(subject *s, fmi2Status status, int allowed);
/* serialise the present state of the subject, without the call being counted */
void judge_take_image(subject *s, image *taken);

#endif
