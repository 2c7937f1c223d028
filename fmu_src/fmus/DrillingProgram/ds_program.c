#include "ds_program.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define AT_ONCE 1e-9  /* s, a change within this of a communication point is taken to be at it, times max(1, |t|) */
#define LINE_SIZE 256 /* bytes of a line of the file */
#define HEADER "time,speed,WOB"
#define UNREADABLE "table %.300s cannot be read; expected a CSV file with the header " HEADER
#define BLANKS " \t\r\n"
#define BYTE_ORDER_MARK "\xef\xbb\xbf"

static double late_of(double time)
{
    return time + AT_ONCE * (fabs(time) > 1.0 ? fabs(time) : 1.0);
}

ds_point ds_change_at(const ds_change *change, double time)
{
    const double late = late_of(time);
    ds_point point = {change->initial, 0.0};
    if (late < change->start) {
        return point;
    }
    if (late >= change->start + change->duration) {
        point.value = change->final;
        return point;
    }
    point.slope = (change->final - change->initial) / change->duration;
    point.value = change->initial + point.slope * (time - change->start);
    return point;
}

ds_point ds_table_at(const ds_row rows[], size_t count, double time, int column)
{
    const double late = late_of(time);
    size_t last = 0;
    for (size_t i = 0; i < count && !(rows[i].cell[0] > late); ++i) {
        last = i;
    }
    ds_point point = {rows[last].cell[column], 0.0};
    if (last + 1 == count || late < rows[last].cell[0]) {
        return point;
    }
    const ds_row *const row = &rows[last];
    const ds_row *const after = &rows[last + 1];
    point.slope = (after->cell[column] - row->cell[column]) / (after->cell[0] - row->cell[0]);
    point.value = row->cell[column] + point.slope * (time - row->cell[0]);
    return point;
}

/* remove blanks and line ends, in place */
static void squeeze(char *line)
{
    char *to = line;
    for (const char *from = line; *from != '\0'; ++from) {
        if (strchr(BLANKS, *from) == NULL) {
            *to++ = *from;
        }
    }
    *to = '\0';
}

/* one number up to `stop`; the host may have set a locale with another decimal point */
static int number(const char *text, char stop, double *value, const char **rest)
{
    char copy[64];
    text += strspn(text, BLANKS);
    const size_t length = strspn(text, "0123456789+-.eE");
    const char *const after = text + length + strspn(text + length, BLANKS);
    if (length == 0 || length >= sizeof copy || *after != stop) {
        return 0;
    }
    memcpy(copy, text, length);
    copy[length] = '\0';
    char *const point = strchr(copy, '.');
    if (point != NULL) {
        *point = localeconv()->decimal_point[0];
    }
    char *end;
    *value = strtod(copy, &end);
    *rest = after + (stop != '\0');
    return *end == '\0';
}

/* what is wrong with a line, NULL if it is a row */
static const char *parse(const char *line, ds_row *row)
{
    const char *rest = line;
    if (!number(rest, ',', &row->cell[0], &rest) || !number(rest, ',', &row->cell[1], &rest) ||
        !number(rest, '\0', &row->cell[2], &rest)) {
        return "expected three numbers";
    }
    if (!(fabs(row->cell[0]) <= 1e9 && fabs(row->cell[1]) <= 1e4 && row->cell[2] >= 0.0 && row->cell[2] <= 1e8)) {
        return "expected |time| <= 1e9 s, |speed| <= 1e4 rad/s, 0 <= WOB <= 1e8 N";
    }
    return NULL;
}

/* what is wrong with the order of times, NULL if nothing is; `before` holds the last two rows */
static const char *disorder(const ds_row before[2], size_t count, const ds_row *row)
{
    if (count > 0 && row->cell[0] < before[0].cell[0]) {
        return "expected times that do not fall, at most two rows at one time";
    }
    if (count > 1 && row->cell[0] == before[1].cell[0]) {
        return "expected times that do not fall, at most two rows at one time";
    }
    return NULL;
}

static size_t read_rows(FILE *file, ds_row rows[], size_t most, size_t *line_number, const char **wrong)
{
    char line[LINE_SIZE];
    ds_row before[2] = {{{0.0, 0.0, 0.0}}, {{0.0, 0.0, 0.0}}};
    size_t count = 0;
    while (*wrong == NULL && fgets(line, sizeof line, file) != NULL) {
        ds_row row;
        *line_number += 1;
        if (*line_number == 1) {
            squeeze(line);
            const size_t mark = strncmp(line, BYTE_ORDER_MARK, 3) == 0 ? 3 : 0;
            *wrong = strcmp(line + mark, HEADER) == 0 ? NULL : "expected the header " HEADER;
            continue;
        }
        if (line[strspn(line, BLANKS)] == '\0') {
            continue;
        }
        *wrong = parse(line, &row);
        if (*wrong == NULL) {
            *wrong = disorder(before, count, &row);
        }
        if (*wrong == NULL) {
            if (rows != NULL && count < most) {
                rows[count] = row;
            }
            before[1] = before[0];
            before[0] = row;
            count += 1;
        }
    }
    return count;
}

size_t ds_table_read(const char *path, ds_row rows[], size_t most, char *reason, size_t reason_size)
{
    const char *wrong = NULL;
    size_t line_number = 0;
    FILE *const file = fopen(path, "r");
    if (file == NULL) {
        snprintf(reason, reason_size, UNREADABLE, path);
        return 0;
    }
    const size_t count = read_rows(file, rows, most, &line_number, &wrong);
    const int unreadable = ferror(file);
    fclose(file);
    if (unreadable) { /* a folder opens as a file, but cannot be read */
        snprintf(reason, reason_size, UNREADABLE, path);
        return 0;
    }
    if (wrong != NULL) {
        snprintf(reason, reason_size, "table %.300s, line %.0f: %s", path, (double)line_number, wrong);
        return 0;
    }
    if (count == 0) {
        snprintf(reason, reason_size, "table %.300s has no rows; expected at least one", path);
    }
    return count;
}
