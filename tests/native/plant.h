/* The times of the plant, from its parameters as they are set. */
#ifndef PLANT_H
#define PLANT_H

#include "subject.h"

/* whether the model is a plant */
int is_plant(void);
/* s, in which a wave goes along the string */
double plant_travel_time(const subject *s);
/* J, lost along the string */
double plant_string_loss(const subject *s);
/* 1, share that a block of a wave loses while it crosses another, at most: the error of the damping is its square */
double plant_crossing_loss(const subject *s);

#endif
