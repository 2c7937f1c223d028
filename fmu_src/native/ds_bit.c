#include "ds_bit.h"

#include <math.h>

#include "ds_collocation.h"
#include "ds_work.h"

#define SHORTEST_SLIP 1e-9 /* a release that would stop again within this part of a piece is none */
#define MOST_HALVINGS 30   /* more are not made */
#define PIECE 0.5          /* 1, work of a piece beside its collocation, in blocks */
#define HALVING 0.15       /* 1, work of halving a piece, however often */
#define LOOSEST 10.0       /* times the truncation asked for, to which it rises where strong breaks are folded: beyond,
                            * the energy that the bit gains would no longer be what the waves bring */

void ds_bit_start(ds_bit *bit, const ds_clock *clock, double speed)
{
    bit->accuracy = ds_accuracy_on(clock);
    bit->block = 0;
    bit->begin = 0.0;
    bit->end = 0.0;
    bit->direction = speed > 0.0 ? 1 : speed < 0.0 ? -1 : 0;
    bit->stops = 0;
    bit->releases = 0;
    bit->halted = 0;
    bit->whole = 0;
    bit->slips = 0;
    bit->truncation = 0.0;
    bit->roughness = 0.0;
    bit->power = 0.0;
    bit->incident = DS_NO_PIECE.wave;
    bit->turning = DS_NO_PIECE.wave;
    bit->incoming = DS_NO_PIECE;
    bit->speed = speed;
    bit->weight = 0.0;
    bit->weight_rise = 0.0;
    bit->angle = 0.0;
    bit->loss = 0.0;
    bit->stuck = 0.0;
    bit->last_stop = clock->start;
    bit->last_release = clock->start;
    bit->earning = 0.0;
    bit->credit = 0.0;
}

void ds_bit_endow(ds_bit *bit, double earning)
{
    bit->earning = earning;
    bit->credit = DS_SAVED * earning;
}

void ds_bit_earn(ds_bit *bit, double work)
{
    const double credit = bit->credit + work;
    const double most = DS_SAVED * bit->earning;
    bit->credit = most < credit ? most : credit;
}

/* integrate the bit equation over the piece as it is */
static void collocate(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit, int last_try)
{
    const double duration = (bit->end - bit->begin) * clock->block;
    const ds_wob wob = {bit->weight, bit->weight_rise};
    const ds_accuracy accuracy = {bit->truncation, bit->accuracy.newton};
    const ds_slip slip =
        ds_slip_collocate(law, &accuracy, bit->direction, duration, bit->speed, bit->incident, wob, last_try);
    bit->turning = slip.speed;
    bit->power = slip.power;
    bit->roughness = slip.roughness;
    bit->whole = 1;
    bit->credit = bit->credit - slip.work;
}

/* end the piece at x, which is at `fraction` of the block */
static void shorten(ds_bit *bit, double x, double fraction)
{
    bit->incident = ds_quartic_restrict(bit->incident, 0.0, x);
    bit->turning = ds_quartic_restrict(bit->turning, 0.0, x);
    bit->weight_rise = x * bit->weight_rise;
    bit->end = fraction;
    bit->whole = 0;
}

/* halve the piece, again while its begin shows that it is too rough, at most so often; how often it was */
static int halve(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit, int most)
{
    const double derivative =
        -ds_friction_at(&law->friction, bit->weight, bit->direction * bit->speed).slope - law->damping;
    double end = bit->end;
    double x = 1.0;
    int count = 0;
    while (count < most) {
        end = bit->begin + 0.5 * (end - bit->begin);
        x = 0.5 * x;
        ++count;
        const double duration = (end - bit->begin) * clock->block;
        if (!(fabs(duration / law->inertia * derivative) / DS_GREATEST_STIFFNESS > 1.0)) {
            break;
        }
    }
    shorten(bit, x, end);
    bit->credit = bit->credit - HALVING;
    return count;
}

/* integrate the bit equation over the piece, or up to the place where the bit comes to rest */
static void slip(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit)
{
    int halvings = 0;
    collocate(law, clock, bit, 0);
    while (halvings < MOST_HALVINGS && !(bit->roughness <= 1.0)) {
        halvings += halve(law, clock, bit, MOST_HALVINGS - halvings);
        collocate(law, clock, bit, halvings == MOST_HALVINGS);
    }
    const ds_quartic t = bit->turning;
    const ds_quartic back = {-t.c0, -t.c1, -t.c2, -t.c3, -t.c4};
    const double x = ds_quartic_first_positive(bit->direction > 0 ? back : t);
    if (x > 1.0) {
        return;
    }
    if (bit->speed == 0.0 && x < SHORTEST_SLIP) {
        bit->direction = 0;
        return;
    }
    shorten(bit, x, bit->begin + x * (bit->end - bit->begin));
    bit->stops = 1;
}

/* by how much the torque on the stuck bit exceeds the static friction ahead and back: first place of each */
static void excess_places(const ds_bit_law *law, const ds_bit *bit, double *ahead, double *back)
{
    const double z = law->twice_impedance;
    const ds_quartic a = bit->incident;
    const double holding = law->friction.static_ * bit->weight;
    const double rise = law->friction.static_ * bit->weight_rise;
    const ds_quartic over = {z * a.c0 - holding, z * a.c1 - rise, z * a.c2, z * a.c3, z * a.c4};
    const ds_quartic below = {-(z * a.c0) - holding, -(z * a.c1) - rise, -(z * a.c2), -(z * a.c3), -(z * a.c4)};
    *ahead = ds_quartic_first_positive(over);
    *back = ds_quartic_first_positive(below);
}

/* count a release, but not a passage through rest, nor one again that is decided anew */
static void count_release(const ds_clock *clock, ds_bit *bit)
{
    const double time = ds_clock_time(clock, bit->block, bit->begin);
    if (!bit->halted && (bit->slips == 0 || time != bit->last_release)) {
        bit->last_release = time;
        bit->slips += 1;
    }
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
            count_release(clock, bit);
            return;
        }
        x = DS_NONE;
    }
    if (bit->halted) {
        bit->last_stop = ds_clock_time(clock, bit->block, bit->begin);
    }
    bit->turning = DS_NO_PIECE.wave;
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
    bit->incident = ds_quartic_restrict(bit->incoming.wave, (bit->begin - first) / (last - first), 1.0);
    bit->weight = ds_ramp_at(&bit->wob, clock, bit->block, bit->begin, bit->end, &bit->weight_rise);
    bit->stops = 0;
    /* hardly anything need be followed closer than the breaks that are folded */
    const double asked = bit->accuracy.truncation;
    bit->truncation = fmin(fmax(asked, ds_line_threshold(down)), LOOSEST * asked);
    if (bit->speed == 0.0) {
        bit->direction = 0; /* whatever it was about to do, inputs may have changed since */
        rest(law, clock, bit);
    } else {
        slip(law, clock, bit);
    }
    bit->halted = 0;
}

void ds_bit_close(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit, ds_line *up, ds_piece *up_ring)
{
    const ds_piece piece = {bit->begin, bit->end, ds_quartic_subtract(bit->turning, bit->incident), 0.0};
    ds_line_push(up, up_ring, piece);
    ds_bit_finish(law, clock, bit);
}

void ds_bit_finish(const ds_bit_law *law, const ds_clock *clock, ds_bit *bit)
{
    const double duration = (bit->end - bit->begin) * clock->block;
    if (bit->direction == 0) {
        bit->stuck += duration;
    } else {
        bit->angle += duration * ds_quartic_integral(bit->turning, 1.0);
        bit->loss += duration * (bit->whole ? bit->power : ds_bit_power_integral(law, bit, 1.0));
        bit->speed = ds_quartic_end(bit->turning);
    }
    if (bit->stops) {
        bit->speed = 0.0;
        bit->direction = 0;
        bit->halted = 1;
    }
    ds_bit_earn(bit, bit->earning * duration - PIECE);
    bit->begin = bit->end;
    if (bit->end >= 1.0) {
        bit->block += 1;
        bit->begin = 0.0;
        bit->incoming = DS_NO_PIECE;
    }
}

int ds_bit_cut(ds_bit *bit, double fraction)
{
    if (!(fraction - bit->begin > DS_SNAP)) {
        return 0;
    }
    if (bit->end - fraction > DS_SNAP) {
        shorten(bit, (fraction - bit->begin) / (bit->end - bit->begin), fraction);
        bit->stops = 0;
        bit->releases = 0;
    }
    return 1;
}

double ds_bit_torque(const ds_bit_law *law, const ds_bit *bit, double x)
{
    if (bit->direction == 0) {
        return law->twice_impedance * ds_quartic_value(bit->incident, x);
    }
    const double speed = ds_quartic_value(bit->turning, x);
    const double weight = bit->weight + x * bit->weight_rise;
    const double dry = ds_friction_at(&law->friction, weight, bit->direction * speed).torque;
    return law->viscosity * speed + dry * bit->direction;
}

double ds_bit_power_integral(const ds_bit_law *law, const ds_bit *bit, double x)
{
    double total = 0.0;
    if (bit->direction == 0) {
        return 0.0;
    }
    for (int i = 0; i < 4; ++i) {
        const double at = ds_nodes[i] * x;
        total = total + ds_weights[i] * (ds_bit_torque(law, bit, at) * ds_quartic_value(bit->turning, at));
    }
    return x * total;
}

void ds_bit_extremes(const ds_bit *bit, double x0, double x1, double *least, double *greatest)
{
    if (bit->direction == 0) {
        *least = 0.0;
        *greatest = 0.0;
        return;
    }
    ds_quartic_extremes(bit->turning, x0, x1, least, greatest);
    /* where it comes to rest, rounding may leave it beyond */
    if (bit->direction > 0 && !(*least > 0.0)) {
        *least = 0.0;
    }
    if (bit->direction < 0 && !(*greatest < 0.0)) {
        *greatest = 0.0;
    }
}
