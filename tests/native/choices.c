#include "choices.h"

#include <float.h>
#include <math.h>
#include <string.h>

void choices_of_seed(uint64_t seed, uint8_t bytes[], size_t n)
{
    uint64_t state = seed;
    for (size_t i = 0; i < n; ++i) {
        /* splitmix64 (Steele, Lea, Flood 2014) */
        state += 0x9e3779b97f4a7c15u;
        uint64_t z = state;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        bytes[i] = (uint8_t)((z ^ (z >> 31)) >> 56);
    }
}

uint8_t choose_byte(choices *from)
{
    if (from->left == 0) {
        return 0;
    }
    from->left -= 1;
    return *from->bytes++;
}

int choose_below(choices *from, int n)
{
    return choose_byte(from) % n;
}

double choose_fraction(choices *from)
{
    const int high = choose_byte(from);
    const int low = choose_byte(from);
    return (high * 256 + low) / 65536.0;
}

double choose_scale(choices *from)
{
    static const double SCALES[] = {1.0, 0.5, 0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-6, 1e-9};
    return SCALES[choose_below(from, sizeof SCALES / sizeof *SCALES)];
}

double choose_bits(choices *from)
{
    uint64_t bits = 0;
    double value;
    for (int i = 0; i < 8; ++i) {
        bits = bits << 8 | choose_byte(from);
    }
    memcpy(&value, &bits, sizeof value);
    return value;
}

static double within(const ds_variable *variable, double value)
{
    return fmin(fmax(value, variable->minimum), variable->maximum);
}

/* near the start value; of an input also 0 and the other direction */
static double ordinary(choices *from, const ds_variable *variable)
{
    const double x = choose_fraction(from);
    if (variable->start == 0.0) {
        const double size = strcmp(variable->unit, "N.m") == 0 ? 2e4 : 20.0;
        return within(variable, size * (2.0 * x - 1.0));
    }
    if (variable->role == DS_INPUT) {
        return within(variable, variable->start * (x < 0.1 ? 0.0 : 3.0 * x - 1.0));
    }
    return within(variable, variable->start * (0.5 + x));
}

/* anywhere in the range, any order of magnitude alike */
static double anywhere(choices *from, const ds_variable *variable)
{
    const double bits = fabs(choose_bits(from));
    const double x = choose_fraction(from);
    switch (choose_below(from, 4)) {
    case 0:
        return variable->minimum;
    case 1:
        return variable->maximum;
    case 2:
        return isfinite(bits) ? within(variable, bits) : variable->start;
    default:
        return within(variable, ldexp(variable->start == 0.0 ? 1.0 : variable->start, (int)(40.0 * x) - 20));
    }
}

static double unsound(choices *from, const ds_variable *variable)
{
    switch (choose_below(from, 8)) {
    case 0:
        return nextafter(variable->minimum, -DBL_MAX);
    case 1:
        return nextafter(variable->maximum, DBL_MAX);
    case 2:
        return NAN;
    case 3:
        return INFINITY;
    case 4:
        return -INFINITY;
    case 5:
        return -0.0;
    default:
        return choose_bits(from);
    }
}

double choose_number(choices *from, const ds_variable *variable, int wild)
{
    const int kind = choose_below(from, 16);
    if (kind == 0) {
        const double value = unsound(from, variable);
        const int legal = value >= variable->minimum && value <= variable->maximum;
        return legal && !wild ? variable->start : value;
    }
    return kind < 8 && wild ? anywhere(from, variable) : ordinary(from, variable);
}
