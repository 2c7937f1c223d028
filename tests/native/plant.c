#include "plant.h"

#include <math.h>

int is_plant(void)
{
    return variable_named("bit_stuck") >= 0;
}

double plant_travel_time(const subject *s)
{
    return subject_value(s, "L") * sqrt(subject_value(s, "I") / (subject_value(s, "G") * subject_value(s, "J")));
}

double plant_string_loss(const subject *s)
{
    return variable_named("string_loss") >= 0 ? subject_value(s, "string_loss") : 0.0;
}

double plant_crossing_loss(const subject *s)
{
    if (variable_named("beta") < 0) {
        return 0.0;
    }
    const double block = 8.0 * plant_travel_time(s) / subject_value(s, "cells_used");
    return fmin(0.25 * subject_value(s, "beta") / subject_value(s, "I") * block, 0.125);
}
