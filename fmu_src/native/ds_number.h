/* Numbers in messages: as few digits as read back to the same number. */
#ifndef DS_NUMBER_H
#define DS_NUMBER_H

#include <stdio.h>
#include <stdlib.h>

typedef struct {
    char text[32];
} ds_number_text;

static inline ds_number_text ds_number(double value)
{
    ds_number_text shown;
    int digits = 15;
    do {
        snprintf(shown.text, sizeof shown.text, "%.*g", digits, value);
        digits += 1;
    } while (digits <= 17 && strtod(shown.text, NULL) != value);
    return shown;
}

#endif
