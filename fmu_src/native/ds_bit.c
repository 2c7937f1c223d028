#include "ds_bit.h"

#include "ds_exp.h"

#define SHORTEST_SLIP 1e-9 /* a release that would stop again within this part of a piece is none */
#define ROOT_STEPS 6       /* Newton steps that carry a stop from the interpolant to the integrator's own zero */

static const ds_piece NOTHING = {0.0, 0.0, {0.0, 0.0, 0.0, 0.0}};

void ds_bit_start(ds_bit *bit, const ds_clock *clock, double speed)
{
    bit->cell = 0;
    bit->begin = 0.0;
    bit->end = 0.0;
    bit->direction = speed > 0.0 ? 1 : speed < 0.0 ? -1 : 0;
    bit->stops = 0;
    bit->releases = 0;
    bit->arrived = 0;
    bit->slips = 0;
    bit->arriving = NOTHING.wave;
    bit->turning = NOTHING.wave;
    bit->incoming = NOTHING;
    bit->speed = speed;
    bit->weight = 0.0;
    bit->weight_rise = 0.0;
    bit->angle = 0.0;
    bit->loss = 0.0;
    bit->stuck = 0.0;
    bit->last_stop = clock->start;
    bit->last_release = clock->start;
}

/* dry friction torque of a slip in `direction`, continued smoothly through rest */
static double dry(const ds_bit_law *law, double weight, int direction, double speed)
{
    return weight * (law->coulomb + law->excess * ds_exp(-law->rate * (direction * speed))) * direction;
}

/* dv/dt at x of the piece */
static double acceleration(const ds_bit_law *law, const ds_bit *bit, double x, double speed)
{
    const double friction = dry(law, bit->weight + x * bit->weight_rise, bit->direction, speed);
    return (law->twice_impedance * ds_cubic_value(bit->arriving, x) - law->damping * speed - friction) / law->inertia;
}

/* speed and acceleration at x of the piece by one Runge-Kutta step of order four from its begin */
static double integrate(const ds_bit_law *law, const ds_clock *clock, const ds_bit *bit, double begin, double x,
                        double *end)
{
    const double step = x * ((bit->end - bit->begin) * clock->cell);
    const double half = 0.5 * step;
    const double middle = 0.5 * x;
    const double k2 = acceleration(law, bit, middle, bit->speed + half * begin);
    const double k3 = acceleration(law, bit, middle, bit->speed + half * k2);
    const double k4 = acceleration(law, bit, x, bit->speed + step * k3);
    const double speed = bit->speed + step * (0.16666666666666666 * (begin + 2.0 * (k2 + k3) + k4));
    *end = acceleration(law, bit, x, speed);
    return speed;
}

/* where the integrator itself comes to rest, from the zero of its interpolant (Newton) */
static double stop_place(const ds_bit_law *law, const ds_clock *clock, const ds_bit *bit, double begin, double x)
{
    const double duration = (bit->end - bit->begin) * clock->cell;
    double best = x;
    for (int i = 0; i < ROOT_STEPS; ++i) {
        double slope;
        const double speed = integrate(law, clock, bit, begin, best, &slope);
        if (slope == 0.0) {
            return x;
        }
        best = best - speed / (slope * duration);
        if (!(0.5 * x < best && best <= 1.0)) { /* a slip from rest has a second zero, its begin */
            return x;
        }
    }
    return best;
}

/* integrate the bit equation over the piece, or up to the place where the bit comes to rest */
static void slip(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit)
{
    double begin = acceleration(law, bit, 0.0, bit->speed);
    double end;
    if (bit->speed == 0.0 && begin * bit->direction < 0.0) {
        begin = 0.0; /* by rounding: at a release the friction is overcome */
    }
    const double speed = integrate(law, clock, bit, begin, 1.0, &end);
    const double duration = (bit->end - bit->begin) * clock->cell;
    bit->turning = ds_cubic_hermite(bit->speed, speed, duration * begin, duration * end);
    const ds_cubic t = bit->turning;
    const ds_cubic back = {-t.c0, -t.c1, -t.c2, -t.c3};
    double x = ds_cubic_first_positive(bit->direction > 0 ? back : t);
    if (x > 1.0) {
        return;
    }
    if (bit->speed == 0.0 && x < SHORTEST_SLIP) {
        bit->direction = 0;
        return;
    }
    x = stop_place(law, clock, bit, begin, x);
    end = acceleration(law, bit, x, 0.0);
    bit->turning = ds_cubic_hermite(bit->speed, 0.0, x * duration * begin, x * duration * end);
    bit->arriving = ds_cubic_restrict(bit->arriving, 0.0, x);
    bit->weight_rise = x * bit->weight_rise;
    bit->end = bit->begin + x * (bit->end - bit->begin);
    bit->stops = 1;
}

/* end the piece at x, which is at `fraction` of the cell */
static void shorten(ds_bit *bit, double x, double fraction)
{
    bit->arriving = ds_cubic_restrict(bit->arriving, 0.0, x);
    bit->turning = ds_cubic_restrict(bit->turning, 0.0, x);
    bit->weight_rise = x * bit->weight_rise;
    bit->end = fraction;
}

/* by how much the torque on the stuck bit exceeds the static friction ahead and back: first place of each */
static void excess_places(const ds_bit_law *law, const ds_bit *bit, double *ahead, double *back)
{
    const double z = law->twice_impedance;
    const ds_cubic a = bit->arriving;
    const double holding = law->static_ * bit->weight;
    const double rise = law->static_ * bit->weight_rise;
    const ds_cubic over = {z * a.c0 - holding, z * a.c1 - rise, z * a.c2, z * a.c3};
    const ds_cubic below = {-(z * a.c0) - holding, -(z * a.c1) - rise, -(z * a.c2), -(z * a.c3)};
    *ahead = ds_cubic_first_positive(over);
    *back = ds_cubic_first_positive(below);
}

/* keep the bit stuck up to the end of the piece or its release; at a release, begin to slip */
static void rest(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit)
{
    double ahead;
    double back;
    excess_places(law, bit, &ahead, &back);
    double x = ahead <= back ? ahead : back;
    if (bit->releases != 0 || x < SHORTEST_SLIP) {
        bit->direction = bit->releases != 0 ? bit->releases : ahead <= back ? 1 : -1;
        bit->releases = 0;
        slip(law, clock, bit);
        if (bit->direction != 0) {
            if (!bit->arrived) { /* passing through rest is neither a stop nor a release */
                bit->last_release = ds_clock_time(clock, bit->cell, bit->begin);
                bit->slips += 1;
            }
            return;
        }
        x = DS_NONE;
    }
    if (bit->arrived) {
        bit->last_stop = ds_clock_time(clock, bit->cell, bit->begin);
    }
    bit->turning = NOTHING.wave;
    bit->releases = 0;
    if (x < 1.0) {
        shorten(bit, x, bit->begin + x * (bit->end - bit->begin));
        bit->releases = ahead <= back ? 1 : -1;
    }
}

void ds_bit_open(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit, ds_line *down, const ds_piece *down_ring)
{
    if (bit->begin >= bit->incoming.end) {
        bit->incoming = ds_line_pop(down, down_ring);
        bit->begin = bit->incoming.begin;
    }
    bit->end = bit->incoming.end;
    const double first = bit->incoming.begin;
    const double last = bit->incoming.end;
    bit->arriving = ds_cubic_restrict(bit->incoming.wave, (bit->begin - first) / (last - first), 1.0);
    bit->weight = ds_ramp_at(&bit->pressure, clock, bit->cell, bit->begin, bit->end, &bit->weight_rise);
    bit->stops = 0;
    if (bit->direction == 0) {
        rest(law, clock, bit);
    } else {
        slip(law, clock, bit);
    }
    bit->arrived = 0;
}

void ds_bit_close(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit, ds_line *up, ds_piece *up_ring)
{
    const double duration = (bit->end - bit->begin) * clock->cell;
    const ds_piece piece = {bit->begin, bit->end, ds_cubic_subtract(bit->turning, bit->arriving)};
    if (bit->direction == 0) {
        bit->stuck += duration;
    } else {
        const ds_cubic v = bit->turning;
        bit->angle += duration * ds_cubic_integral(v, 1.0);
        bit->loss += duration * ds_bit_power_integral(law, bit, 1.0);
        bit->speed = v.c0 + v.c1 + v.c2 + v.c3;
    }
    ds_line_push(up, up_ring, piece);
    if (bit->stops) {
        bit->speed = 0.0;
        bit->direction = 0;
        bit->arrived = 1;
    }
    bit->begin = bit->end;
    if (bit->end >= 1.0) {
        bit->cell += 1;
        bit->begin = 0.0;
        bit->incoming = NOTHING;
    }
}

void ds_bit_cut(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit, double fraction, ds_line *up,
                ds_piece *up_ring)
{
    if (fraction - bit->begin > DS_SNAP) {
        if (bit->end - fraction > DS_SNAP) {
            shorten(bit, (fraction - bit->begin) / (bit->end - bit->begin), fraction);
            bit->stops = 0;
            bit->releases = 0;
        }
        ds_bit_close(law, clock, bit, up, up_ring);
    }
}

double ds_bit_torque(const ds_bit_law *law, const ds_bit *bit, double x)
{
    if (bit->direction == 0) {
        return law->twice_impedance * ds_cubic_value(bit->arriving, x);
    }
    const double speed = ds_cubic_value(bit->turning, x);
    return law->viscosity * speed + dry(law, bit->weight + x * bit->weight_rise, bit->direction, speed);
}

double ds_bit_power_integral(const ds_bit_law *law, const ds_bit *bit, double x)
{
    if (bit->direction == 0) {
        return 0.0;
    }
    const double middle = 0.5 * x;
    const double begin = ds_bit_torque(law, bit, 0.0) * bit->turning.c0;
    const double centre = ds_bit_torque(law, bit, middle) * ds_cubic_value(bit->turning, middle);
    const double end = ds_bit_torque(law, bit, x) * ds_cubic_value(bit->turning, x);
    return x * (0.16666666666666666 * (begin + 4.0 * centre + end));
}

void ds_bit_extremes(const ds_bit *bit, double x0, double x1, double *least, double *greatest)
{
    if (bit->direction == 0) {
        *least = 0.0;
        *greatest = 0.0;
        return;
    }
    ds_cubic_extremes(bit->turning, x0, x1, least, greatest);
}
