/* Sequences of calls that are written down, each for something a random one may miss. */
#ifndef WALKS_H
#define WALKS_H

#include "subject.h"

typedef struct {
    const char *needs; /* a variable of the models it is made for */
    const char *name;
    void (*walk)(session *run, subject *s);
} walk;

/* the last of each has no function */
extern const walk walks_of_plants[];
extern const walk walks_of_laws[];

/* a table with all that a table may have */
extern const char SOUND_TABLE[];

/* write lines to a file and set it as the table of a program */
void set_table(subject *s, const char *lines);

/* everything the model is made to show, with every number written to run->out */
void walk_all(session *run);
/* what an importer does from the first call to the last, with states saved, serialised and moved; every call that is
 * refused, as only want of memory can make it, is repeated and then accepted */
void walk_life(session *run);
/* instantiations that are refused */
void walk_refusals(session *run);

#endif
