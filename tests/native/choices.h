/* Decisions taken from bytes: those of a seed, or those a fuzzer makes up. All arithmetic is exact or correctly
 * rounded, so that the same bytes are the same decisions on every platform. */
#ifndef CHOICES_H
#define CHOICES_H

#include <stddef.h>
#include <stdint.h>

#include "ds_interface.h"

typedef struct {
    const uint8_t *bytes;
    size_t left;
} choices;

/* fill with the bytes of a seed */
void choices_of_seed(uint64_t seed, uint8_t bytes[], size_t n);

/* 0 when there are none left */
uint8_t choose_byte(choices *from);
/* one of 0 ... n - 1, n at most 256 */
int choose_below(choices *from, int n);
/* in [0, 1) */
double choose_fraction(choices *from);
/* a size between 1e-9 and 1, any order of magnitude alike */
double choose_scale(choices *from);
/* a number for a variable, mostly in its range and near its start value; if `wild`, anywhere in its range */
double choose_number(choices *from, const ds_variable *variable, int wild);
/* any double at all */
double choose_bits(choices *from);

#endif
