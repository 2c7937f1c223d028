/* What the generated table of a model (ds_table.h, ds_table.c) is made of. */
#ifndef DS_INTERFACE_H
#define DS_INTERFACE_H

typedef enum { DS_REAL, DS_INTEGER, DS_BOOLEAN, DS_STRING } ds_kind; /* enumerations are DS_INTEGER */
typedef enum { DS_INPUT, DS_OUTPUT, DS_FIXED, DS_TUNABLE } ds_role;

typedef struct {
    const char *name;
    const char *unit;
    const char *type; /* its name in FMI 2.0 */
    ds_kind kind;
    ds_role role;
    double start; /* of a String: the number of its text slot */
    double minimum;
    double maximum;
} ds_variable;

#endif
