/* The operations of a sequence that set and read variables. */
#include <limits.h>
#include <math.h>
#include <string.h>

#include "operations.h"

enum { MOST_SET = 4 };

/* a number for a variable that its type can hold */
static double choose_typed(sequence *q, const ds_variable *variable)
{
    if (variable->kind == DS_REAL) {
        return choose_number(&q->from, variable, q->wild);
    }
    if (variable->kind == DS_BOOLEAN) {
        return choose_below(&q->from, 2);
    }
    static const int INTEGERS[] = {0, 1, 2, 3, 4, 5, 17, 40, 64, 100, 200000, 200001, -1, INT_MAX, INT_MIN, 257};
    return INTEGERS[choose_below(&q->from, 16)];
}

/* a value reference, mostly one that can be set, of a kind */
static fmi2ValueReference choose_reference(sequence *q, ds_kind kind)
{
    const int first = choose_byte(&q->from);
    if (first == 255) {
        return DS_VARIABLES + (fmi2ValueReference)choose_byte(&q->from) * 0x01010101u;
    }
    if (first >= 248) {
        return (fmi2ValueReference)(first % DS_VARIABLES);
    }
    for (int i = 0; i < DS_VARIABLES; ++i) {
        const int at = (first + i) % DS_VARIABLES;
        if (ds_variables[at].kind == kind && ds_variables[at].role != DS_OUTPUT) {
            return (fmi2ValueReference)at;
        }
    }
    return (fmi2ValueReference)(first % DS_VARIABLES);
}

/* a value reference, mostly of a Real output */
static fmi2ValueReference choose_output(sequence *q)
{
    const int first = choose_byte(&q->from);
    if (first >= 240) {
        return choose_reference(q, DS_REAL);
    }
    int at = first % DS_VARIABLES;
    while (ds_variables[at].kind != DS_REAL || ds_variables[at].role != DS_OUTPUT) {
        at = (at + 1) % DS_VARIABLES;
    }
    return (fmi2ValueReference)at;
}

/* mostly none */
static null_argument choose_null(sequence *q)
{
    const int which = choose_below(&q->from, 64);
    return which <= (int)NULL_ORDERS ? (null_argument)which : NONE_NULL;
}

void set_some(sequence *q, subject *s, ds_kind kind)
{
    fmi2ValueReference vr[MOST_SET];
    double value[MOST_SET];
    const null_argument null = choose_null(q);
    const int n = choose_below(&q->from, MOST_SET + 1);
    for (int i = 0; i < n; ++i) {
        vr[i] = choose_reference(q, kind);
        const ds_variable *const variable = &ds_variables[vr[i] < DS_VARIABLES ? vr[i] : 0];
        const double typed = choose_typed(q, variable);
        value[i] = kind == variable->kind ? typed : 0.0;
    }
    subject_set(s, kind, vr, (size_t)n, value, null == NULL_ORDERS ? NONE_NULL : null);
}

void op_set_reals(sequence *q, subject *s)
{
    set_some(q, s, DS_REAL);
}

void op_set_integers(sequence *q, subject *s)
{
    set_some(q, s, DS_INTEGER);
}

void op_set_booleans(sequence *q, subject *s)
{
    set_some(q, s, DS_BOOLEAN);
}

/* bring inputs near their start values, as an importer does before a step */
void op_drive(sequence *q, subject *s)
{
    for (int i = 0; i < DS_VARIABLES; ++i) {
        const ds_variable *const variable = &ds_variables[i];
        if (variable->role == DS_INPUT && choose_below(&q->from, 2) == 0) {
            const fmi2ValueReference vr = (fmi2ValueReference)i;
            const double value = choose_number(&q->from, variable, 0);
            subject_set(s, DS_REAL, &vr, 1, &value, NONE_NULL);
        }
    }
}

/* write what is next among the bytes to the table, as it is or behind a sound header */
static void write_table(sequence *q)
{
    const int sound = choose_below(&q->from, 4);
    const int n = choose_byte(&q->from);
    FILE *const file = fopen(q->run->table, "wb");
    REQUIRE(q->run, file != NULL, "cannot write %s", q->run->table);
    if (sound > 0) {
        fputs("time,speed,WOB\n", file);
    }
    for (int i = 0; sound > 1 && i < n % 8; ++i) {
        const int time = i - (choose_below(&q->from, 8) == 0);
        fprintf(file, "%d.5,%d,%d\n", time, choose_byte(&q->from), choose_byte(&q->from));
    }
    for (int i = 0; sound < 3 && i < n; ++i) {
        static const char LETTERS[] = "0123456789+-.eE, \t\r\n,,\n\n";
        const uint8_t byte = choose_byte(&q->from);
        fputc(byte < 128 ? LETTERS[byte % (sizeof LETTERS - 1)] : byte, file);
    }
    fclose(file);
}

void op_set_texts(sequence *q, subject *s)
{
    char longer[DS_TEXT_SIZE + 1];
    fmi2ValueReference vr[2];
    fmi2String value[2];
    const null_argument null = choose_null(q);
    const int n = 1 + choose_below(&q->from, 8) / 7;
    memset(longer, 'x', sizeof longer - 1);
    longer[sizeof longer - 1] = '\0';
    for (int i = 0; i < n; ++i) {
        const fmi2String texts[] = {"", q->run->table, q->run->table, "no such file.csv", ".", longer, NULL, "a\nb"};
        vr[i] = choose_reference(q, DS_STRING);
        value[i] = texts[choose_below(&q->from, 8)];
        if (value[i] == q->run->table) {
            write_table(q);
        }
    }
    subject_set_texts(s, vr, (size_t)n, value, null == NULL_ORDERS ? NONE_NULL : null);
}

void op_set_slopes(sequence *q, subject *s)
{
    fmi2ValueReference vr[MOST_SET];
    fmi2Integer order[MOST_SET];
    double value[MOST_SET];
    const double unsound[] = {NAN, INFINITY, -INFINITY, choose_bits(&q->from)};
    const null_argument null = choose_null(q);
    const int n = choose_below(&q->from, MOST_SET);
    for (int i = 0; i < n; ++i) {
        vr[i] = choose_below(&q->from, 8) == 0 ? choose_reference(q, DS_REAL)
                                               : (fmi2ValueReference)(choose_below(&q->from, 2) % DS_VARIABLES);
        order[i] = choose_below(&q->from, 16) == 0 ? choose_byte(&q->from) - 128 : 1;
        const double size = choose_scale(&q->from);
        const int weight = vr[i] < DS_VARIABLES && strcmp(ds_variables[vr[i]].unit, "N") == 0;
        value[i] = (weight ? 1e5 : 100.0) * size * (2.0 * choose_fraction(&q->from) - 1.0);
        value[i] = choose_below(&q->from, 32) == 0 ? unsound[choose_below(&q->from, 4)] : value[i];
    }
    subject_set_slopes(s, vr, (size_t)n, order, value, null);
}

void op_read(sequence *q, subject *s)
{
    bound_cells(q, s);
    subject_read(s);
}

void op_get(sequence *q, subject *s)
{
    fmi2ValueReference vr[MOST_SET];
    const ds_kind kind = (ds_kind)choose_below(&q->from, 4);
    const null_argument null = choose_null(q);
    const int n = choose_below(&q->from, MOST_SET + 1);
    for (int i = 0; i < n; ++i) {
        vr[i] = choose_below(&q->from, 2) ? choose_reference(q, kind) : choose_byte(&q->from) % DS_VARIABLES;
    }
    bound_cells(q, s);
    subject_get(s, kind, vr, (size_t)n, null == NULL_ORDERS ? NONE_NULL : null);
}

void op_get_slopes(sequence *q, subject *s)
{
    fmi2ValueReference vr[MOST_SET];
    fmi2Integer order[MOST_SET];
    const null_argument null = choose_null(q);
    const int n = choose_below(&q->from, MOST_SET + 1);
    for (int i = 0; i < n; ++i) {
        vr[i] = choose_output(q);
        order[i] = choose_below(&q->from, 16) == 0 ? choose_byte(&q->from) - 128 : 1;
    }
    subject_get_slopes(s, vr, (size_t)n, order, null);
}

void op_get_sensitivities(sequence *q, subject *s)
{
    fmi2ValueReference unknown[MOST_SET];
    fmi2ValueReference known[MOST_SET];
    double seed[MOST_SET];
    const int unknowns = choose_below(&q->from, MOST_SET + 1);
    const int knowns = choose_below(&q->from, MOST_SET + 1);
    for (int i = 0; i < MOST_SET; ++i) {
        unknown[i] = choose_output(q);
        known[i] = choose_reference(q, DS_REAL);
        seed[i] = choose_fraction(&q->from);
    }
    bound_cells(q, s);
    subject_get_sensitivities(s, unknown, (size_t)unknowns, known, (size_t)knowns, seed,
                              knowns > 0 && choose_below(&q->from, 16) == 0);
}
