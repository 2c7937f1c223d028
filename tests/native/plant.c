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

double plant_answer_time(const subject *s)
{
    const double impedance = sqrt(subject_value(s, "I") * subject_value(s, "G") * subject_value(s, "J"));
    return subject_value(s, "I_B") / (impedance + subject_value(s, "c_b"));
}
