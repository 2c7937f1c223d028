/* What the bytes of a sequence can stand for; each takes the bytes it needs. */
#ifndef OPERATIONS_H
#define OPERATIONS_H

#include "choices.h"
#include "subject.h"

enum { SUBJECTS = 3, SLOTS = 4 };

typedef struct {
    session *run;
    choices from;
    int wild; /* parameters are taken from their whole range */
    int watched;
    subject subjects[SUBJECTS];
    saved_state slots[SLOTS];
} sequence;

/* keep a plant that is about to start from having so many cells that it takes seconds */
void bound_cells(sequence *q, subject *s);
/* set up to a few variables, mostly of one kind */
void set_some(sequence *q, subject *s, ds_kind kind);

void op_set_reals(sequence *q, subject *s);
void op_set_integers(sequence *q, subject *s);
void op_set_booleans(sequence *q, subject *s);
void op_drive(sequence *q, subject *s);
void op_set_texts(sequence *q, subject *s);
void op_set_slopes(sequence *q, subject *s);
void op_read(sequence *q, subject *s);
void op_get(sequence *q, subject *s);
void op_get_slopes(sequence *q, subject *s);
void op_get_sensitivities(sequence *q, subject *s);

#endif
