/* The steps that walks are made of. */
#ifndef WALKING_H
#define WALKING_H

#include "subject.h"

typedef struct {
    const char *name;
    double value;
} setting;

enum { STEP_SIZES = 8 };

/* s, steps as no importer takes them, so that communication points fall anywhere in cells */
extern const double STEP_SIZE[STEP_SIZES];

/* set a variable by its name; whether it was accepted */
int put(subject *s, const char *name, double value);
/* give an input a derivative for the next step */
void ramp(subject *s, const char *name, double slope);
/* take a step, which must be accepted */
void go(subject *s, double size);
/* read the derivatives of all Real outputs by time */
void read_slopes(subject *s);
/* go on in steps of all sizes until a time has passed, with the derivatives read after each */
void go_on(subject *s, double duration);
/* make an instance with settings, of which the last has no name, and bring it to its first communication point */
void start(subject *s, session *run, const setting settings[], double time);
/* terminate it, read it once more, and free it */
void finish(subject *s);
/* read the derivatives of an output in the direction of one variable at a time, before the start, at it and after a
 * step, with these settings */
void differentiate_at(session *run, subject *s, const setting settings[], const char *output);

#endif
