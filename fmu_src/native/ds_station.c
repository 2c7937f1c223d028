#include "ds_station.h"

#include "ds_exchange.h"

/* a wave at a fraction of a block, from the left */
typedef struct {
    double value;  /* rad/s */
    double slope;  /* rad/s, per block */
    double turned; /* rad/s blocks, its integral from the begin of the block */
} wave_at;

static wave_at look(const ds_line *line, const ds_piece *ring, int index, double fraction)
{
    wave_at w = {0.0, 0.0, 0.0};
    while (ring[index].end < fraction) {
        const ds_piece *const piece = &ring[index];
        w.turned = w.turned + (piece->end - piece->begin) * ds_quartic_integral(piece->wave, 1.0);
        index = ds_ring_next(line, index);
    }
    const ds_piece *const piece = &ring[index];
    const double length = piece->end - piece->begin;
    const double x = (fraction - piece->begin) / length;
    const ds_quartic c = piece->wave;
    w.value = ds_quartic_value(c, x);
    w.slope = (c.c1 + x * (2.0 * c.c2 + x * (3.0 * c.c3 + x * (4.0 * c.c4)))) / length;
    w.turned = w.turned + length * ds_quartic_integral(c, x);
    return w;
}

/* what the formulas of models/plant/station.py share */
typedef struct {
    double after;  /* 1 + kappa x / 2 */
    double before; /* 1 - kappa x / 2 */
    double bend;   /* (kappa x)^2 */
    double speed;  /* rad/s, U + D */
} crossing;

static crossing crossing_of(wave_at u, wave_at d, double fraction, double strength)
{
    const double half = 0.5 * strength * fraction;
    crossing c = {1.0 + half, 1.0 - half, strength * fraction * (strength * fraction), 0.0};
    c.speed = (c.before * (u.value + d.value) - strength * (u.turned + d.turned)) / (c.after - 2.0 * c.bend);
    return c;
}

ds_station_reading ds_station_read(const ds_line *up, const ds_piece *up_ring, int above, const ds_line *down,
                                   const ds_piece *down_ring, int below, double fraction, double strength)
{
    const wave_at u = look(up, up_ring, above, fraction);
    const wave_at d = look(down, down_ring, below, fraction);
    const crossing c = crossing_of(u, d, fraction, strength);
    const double half = 0.5 * strength * fraction;
    const ds_station_reading reading = {
        (c.before * u.value - (strength * d.turned - c.bend * c.speed)) / c.after,
        (c.before * d.value - (strength * u.turned - c.bend * c.speed)) / c.after,
        (u.turned + d.turned) / (1.0 + 2.0 * half),
    };
    return reading;
}

ds_station_reading ds_station_rate(const ds_line *up, const ds_piece *up_ring, int above, const ds_line *down,
                                   const ds_piece *down_ring, int below, double fraction, double strength)
{
    const wave_at u = look(up, up_ring, above, fraction);
    const wave_at d = look(down, down_ring, below, fraction);
    const crossing c = crossing_of(u, d, fraction, strength);
    const ds_station_reading now = ds_station_read(up, up_ring, above, down, down_ring, below, fraction, strength);
    const double half = 0.5 * strength;
    const double twist = 2.0 * strength * strength * fraction; /* derivative of `bend` */
    const double sum = u.value + d.value;
    const double sum_rate = c.before * (u.slope + d.slope) - (half + strength) * sum;
    const double acceleration = (sum_rate - (half - 2.0 * twist) * c.speed) / (c.after - 2.0 * c.bend);
    const double bent = twist * c.speed + c.bend * acceleration;
    const ds_station_reading rate = {
        (c.before * u.slope - half * u.value - strength * d.value + bent - half * now.up) / c.after,
        (c.before * d.slope - half * d.value - strength * u.value + bent - half * now.down) / c.after,
        0.0,
    };
    return rate;
}
