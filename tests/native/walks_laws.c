/* What laws and the driller's program may be asked. */
#include <math.h>
#include <string.h>

#include "walking.h"
#include "walks.h"

#define HEADER "time,speed,WOB\n"

const char SOUND_TABLE[] =
    "\xef\xbb\xbftime, speed, WOB\r\n0,0,0\r\n\r\n2.5,1.25e1,5E4\n2.5,10,50000\n8,-3,97347\n";

static void law_over_its_inputs(session *run, subject *s)
{
    static const setting FORMS[][3] = {
        {{"form", 1.0}, {NULL, 0.0}, {NULL, 0.0}},
        {{"form", 2.0}, {"bit_torque_ref", 7500.0}, {NULL, 0.0}},
    };
    for (int form = 0; form < 2; ++form) {
        start(s, run, FORMS[form], 0.0);
        for (int i = 0; i < 2000; ++i) {
            put(s, "top_speed", i % 100 == 0 ? 0.0 : i % 101 == 0 ? -0.0 : 1e-4 * (i * 7919 % 20011 - 10000));
            put(s, "bit_speed", 0.01 * (i * 104729 % 3001) - 5.0);
            put(s, "bit_speed_ref", 5.0 + i % 13);
            put(s, "c_1", -1.0 + 0.0019 * (i % 1000));
            put(s, "Omega_max", 10.0 + i % 40);
            go(s, STEP_SIZE[i % STEP_SIZES]);
        }
        finish(s);
    }
}

static void weight_over_its_input(session *run, subject *s)
{
    static const setting NOMINAL[] = {{NULL, 0.0}};
    start(s, run, NOMINAL, 0.0);
    for (int i = 0; i < 2000; ++i) {
        put(s, "bit_speed", 0.05 * (i * 7919 % 2003 - 1000));
        put(s, "K_w", 10.0 * (i % 700));
        go(s, STEP_SIZE[i % STEP_SIZES]);
    }
    finish(s);
}

/* every input all over a part of its range, switches on and off */
static void cure_by_settings(session *run, subject *s, const setting settings[], int steps)
{
    start(s, run, settings, 0.0);
    for (int i = 0; i < steps; ++i) {
        for (int k = 0; k < DS_VARIABLES; ++k) {
            const ds_variable *const of = &ds_variables[k];
            const double scale = strncmp(of->unit, "N", 1) == 0 ? 2e4 : 20.0;
            const double asked = of->start + scale * (1e-3 * ((i + 31 * k) * 7919 % 2003) - 1.0);
            if (of->role == DS_INPUT && of->kind == DS_BOOLEAN) {
                put(s, of->name, i / 97 % 2 == 0);
            } else if (of->role == DS_INPUT) {
                put(s, of->name, fmin(fmax(asked, of->minimum), of->maximum));
            }
        }
        go(s, STEP_SIZE[i % STEP_SIZES]);
        read_slopes(s);
    }
    finish(s);
}

static void cure_over_its_inputs(session *run, subject *s)
{
    static const setting NOMINAL[] = {{NULL, 0.0}};
    cure_by_settings(run, s, NOMINAL, 2000);
}

static void cure_in_its_modes(session *run, subject *s)
{
    const ds_variable *const mode = &ds_variables[variable_named("mode")];
    for (double chosen = mode->minimum; chosen <= mode->maximum; chosen += 1.0) {
        const setting settings[] = {{"mode", chosen}, {NULL, 0.0}};
        cure_by_settings(run, s, settings, 300);
    }
}

static void drive_of_an_inertia(session *run, subject *s)
{
    static const setting SETTINGS[][4] = {
        {{"mode", 3.0}, {"J_v", 50.0}, {"filter_time", 0.0}, {NULL, 0.0}},
        {{"mode", 3.0}, {"J_v", 0.0}, {"filter_time", 0.0}, {NULL, 0.0}},
        {{"mode", 3.0}, {"J_v", 0.0}, {"K", 0.0}, {NULL, 0.0}},
    };
    for (size_t i = 0; i < sizeof SETTINGS / sizeof *SETTINGS; ++i) {
        cure_by_settings(run, s, SETTINGS[i], 300);
    }
}

static void program_of_a_change(session *run, subject *s)
{
    static const setting SETTINGS[] = {{"speed_initial", -4.0}, {"speed_start", 1.0},  {"speed_duration", 7.0},
                                       {"WOB_initial", 0.0},    {"WOB_duration", 3.3}, {NULL, 0.0}};
    start(s, run, SETTINGS, 0.0);
    for (int i = 0; i < 200; ++i) {
        go(s, STEP_SIZE[i % STEP_SIZES]);
        read_slopes(s);
    }
    finish(s);
}

void set_table(subject *s, const char *lines)
{
    const fmi2ValueReference vr = (fmi2ValueReference)variable_named("table");
    const fmi2String path = s->run->table;
    FILE *const file = fopen(path, "wb");
    REQUIRE(s->run, file != NULL, "cannot write %s", path);
    fputs(lines, file);
    fclose(file);
    subject_set_texts(s, &vr, 1, &path, NONE_NULL);
}

static void program_of_a_table(session *run, subject *s)
{
    subject_instantiate(s, run, "walker", SOUND, 1);
    set_table(s, SOUND_TABLE);
    subject_set_up(s, -1.0, 0, 0.0);
    subject_enter(s);
    subject_exit(s);
    for (int i = 0; i < 200; ++i) {
        go(s, STEP_SIZE[i % STEP_SIZES]);
        read_slopes(s);
    }
    finish(s);
}

/* files that are no table are refused, and a sound one is taken after them */
static void program_of_no_table(session *run, subject *s)
{
    static const char *const LINES[] = {
        "",
        HEADER,
        "time,speed\n0,0\n",
        HEADER "0,0\n",
        HEADER "0,0,0,0\n",
        HEADER ",0,0\n",
        HEADER "0 0,0,0\n",
        HEADER "0,nan,0\n",
        HEADER "0,1e5,0\n",
        HEADER "2e9,0,0\n",
        HEADER "0,0,-1\n",
        HEADER "0,0,2e8\n",
        HEADER "0,1.2.3,0\n",
        HEADER "0,0.0000000000000000000000000000000000000000000000000000000000000000,0\n",
        HEADER "1,0,0\n0,0,0\n",
        HEADER "1,0,0\n1,0,0\n1,0,0\n",
    };
    const fmi2ValueReference vr = (fmi2ValueReference)variable_named("table");
    const fmi2String folder = ".";
    subject_instantiate(s, run, "reader", SOUND, 1);
    subject_set_up(s, 0.0, 0, 0.0);
    subject_enter(s);
    for (size_t i = 0; i < sizeof LINES / sizeof *LINES; ++i) {
        set_table(s, LINES[i]);
        REQUIRE(run, !subject_exit(s), "a table of the lines\n%s\nis taken", LINES[i]);
    }
    subject_set_texts(s, &vr, 1, &folder, NONE_NULL);
    REQUIRE(run, !subject_exit(s), "a folder is taken for a table");
    set_table(s, SOUND_TABLE);
    REQUIRE(run, subject_exit(s), "a table is refused");
    finish(s);
}

static void law_at_its_corners(session *run, subject *s)
{
    static const setting CORNERS[][7] = {
        {{"top_speed", 0.01}, {"Omega_max", 1e4}, {"c_b", 0.0}, {NULL, 0.0}},
        {{"top_speed", 9.0}, {"bit_speed", 8.0}, {"Omega_max", 1e4}, {"c_b", 0.0}, {NULL, 0.0}},
        {{"form", 2.0}, {"c_1", 0.0}, {"bit_speed", 10.0}, {"Omega_max", 10.0}, {NULL, 0.0}},
        {{"form", 2.0}, {"c_1", 0.0}, {"bit_speed", -10.0}, {"bit_speed_ref", -10.0}, {"Omega_max", 10.0}, {NULL, 0.0}},
        {{"form", 2.0}, {"bit_torque_ref", 1e7}, {NULL, 0.0}},
        {{"form", 2.0}, {"bit_torque_ref", -1e7}, {NULL, 0.0}},
        {{"form", 2.0}, {"bit_torque_ref", 7500.0}, {"top_speed", 9.0}, {"bit_speed", 8.0}, {NULL, 0.0}},
        {{"top_speed", 9.0}, {"bit_speed", 8.0}, {NULL, 0.0}},
        {{"top_speed", -9.0}, {"bit_speed", 8.0}, {"c_1", 0.999}, {NULL, 0.0}},
    };
    for (size_t i = 0; i < sizeof CORNERS / sizeof *CORNERS; ++i) {
        differentiate_at(run, s, CORNERS[i], "Omega");
    }
}

static void weight_at_its_corners(session *run, subject *s)
{
    static const setting CORNERS[][4] = {
        {{"WOB_0", 3e5}, {NULL, 0.0}},
        {{"bit_speed", 1.0}, {NULL, 0.0}},
        {{"bit_speed", -1.0}, {NULL, 0.0}},
        {{"bit_speed", 1e5}, {NULL, 0.0}},
    };
    for (size_t i = 0; i < sizeof CORNERS / sizeof *CORNERS; ++i) {
        differentiate_at(run, s, CORNERS[i], "WOB");
    }
}

const walk walks_of_laws[] = {
    {"form", "inputs", law_over_its_inputs},
    {"form", "corners", law_at_its_corners},
    {"K_w", "inputs", weight_over_its_input},
    {"K_w", "corners", weight_at_its_corners},
    {"handover_time", "inputs", cure_over_its_inputs},
    {"Omega_command", "inputs", cure_over_its_inputs},
    {"torque_initial", "inputs", cure_over_its_inputs},
    {"jump", "inputs", cure_over_its_inputs},
    {"loss", "inputs", cure_over_its_inputs},
    {"feed_max", "inputs", cure_over_its_inputs},
    {"speed_step", "inputs", cure_over_its_inputs},
    {"mode", "modes", cure_in_its_modes},
    {"J_v", "inertia", drive_of_an_inertia},
    {"table", "change", program_of_a_change},
    {"table", "table", program_of_a_table},
    {"table", "no table", program_of_no_table},
    {NULL, NULL, NULL},
};
