/* What the driller asks for over time: one change, or a table. Follows models/controllers/program.py. */
#ifndef DS_PROGRAM_H
#define DS_PROGRAM_H

#include <stddef.h>

#include "ds_linkage.h"

typedef struct {
    double value; /* now */
    double slope; /* 1/s, from now on */
} ds_point;

typedef struct {
    double initial;
    double final;
    double start;    /* s */
    double duration; /* s, 0 is a step */
} ds_change;

typedef struct {
    double cell[3]; /* time [s], speed [rad/s], WOB [N] */
} ds_row;

DS_SHARED ds_point ds_change_at(const ds_change *change, double time);
/* value and derivative of a column (1 or 2) of a table */
DS_SHARED ds_point ds_table_at(const ds_row rows[], size_t count, double time, int column);
/* read a table; rows may be null to count only. Returns the number of rows, 0 with a reason if there is no such table */
DS_SHARED size_t ds_table_read(const char *path, ds_row rows[], size_t most, char *reason, size_t reason_size);

#endif
