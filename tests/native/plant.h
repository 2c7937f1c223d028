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
/* in which the string is computed at most: damping along it asks for blocks that lose little while they cross */
double plant_most_cells(const subject *s);
/* s, in which the bit answers the string: the shortest piece its motion is computed in is about half of it */
double plant_answer_time(const subject *s);

#endif
