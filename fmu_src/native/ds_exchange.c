#include "ds_exchange.h"

/* integrals of the wave and of its square over a block */
typedef struct {
    double mean;   /* rad/s */
    double square; /* rad2/s2 */
} block_moments;

/* a straight line that is added to the wave of a block */
typedef struct {
    double level; /* rad/s, at its begin */
    double rise;  /* rad/s, to its end */
} block_line;

ds_exchange_law ds_exchange_of(double strength)
{
    const double half = 0.5 * strength;
    const ds_exchange_law law = {strength, (1.0 - half) / (1.0 + half), strength / (1.0 + half),
                                 (1.0 - strength) / (1.0 + strength)};
    return law;
}

int ds_exchange_newest(const ds_line *line, const ds_piece *ring)
{
    return ds_exchange_back(line, ring, (line->first + line->count) % line->capacity);
}

int ds_exchange_back(const ds_line *line, const ds_piece *ring, int index)
{
    index = ds_ring_last(line, index);
    while (ring[index].begin > 0.0) {
        index = ds_ring_last(line, index);
    }
    return index;
}

int ds_exchange_forth(const ds_line *line, const ds_piece *ring, int index)
{
    while (ring[index].end < 1.0) {
        index = ds_ring_next(line, index);
    }
    return ds_ring_next(line, index);
}

static block_moments moments_of(const ds_line *line, const ds_piece *ring, int index)
{
    block_moments m = {0.0, 0.0};
    for (;;) {
        const ds_piece *const piece = &ring[index];
        m.mean = m.mean + (piece->end - piece->begin) * ds_quartic_integral(piece->wave, 1.0);
        m.square = m.square + piece->square;
        if (piece->end >= 1.0) {
            return m;
        }
        index = ds_ring_next(line, index);
    }
}

/* replace the wave of a block by `keep` times it and a line; before the last time, its square nearly */
static void change_block(const ds_line *line, ds_piece *ring, int index, double keep, block_line add, int last)
{
    for (;;) {
        ds_piece *const piece = &ring[index];
        const ds_quartic c = piece->wave;
        const double length = piece->end - piece->begin;
        const double start = add.level + add.rise * piece->begin;
        const double slope = add.rise * length;
        const ds_quartic wave = {keep * c.c0 + start, keep * c.c1 + slope, keep * c.c2, keep * c.c3, keep * c.c4};
        if (last) {
            piece->square = length * ds_quartic_square_integral(wave);
        } else {
            const double middle = start + 0.5 * slope;
            const double mean = ds_quartic_integral(c, 1.0);
            piece->square =
                keep * keep * piece->square + length * (2.0 * keep * (middle * mean) + middle * middle);
        }
        piece->wave = wave;
        if (piece->end >= 1.0) {
            return;
        }
        index = ds_ring_next(line, index);
    }
}

/* cross two blocks; the energy lost per Z h */
static double cross(ds_line *up, ds_piece *up_ring, int above, ds_line *down, ds_piece *down_ring, int below,
                    const ds_exchange_law *law, int last)
{
    const block_moments u = moments_of(up, up_ring, above);
    const block_moments d = moments_of(down, down_ring, below);
    const double total = law->decay * (u.mean + d.mean);
    const double u_after = 0.5 * (total + (u.mean - d.mean));
    const double d_after = 0.5 * (total - (u.mean - d.mean));
    const block_line to_u = {-law->share * d.mean, -law->share * (d_after - d.mean)};
    const block_line to_d = {-law->share * u.mean, -law->share * (u_after - u.mean)};
    change_block(up, up_ring, above, law->keep, to_u, last);
    change_block(down, down_ring, below, law->keep, to_d, last);
    /* integral of (U + D)^2 over the cell, each wave being half way between before and after */
    const double half = 0.5 * (1.0 + law->keep);
    const double u_share = -0.25 * law->share * (d.mean + d_after);
    const double d_share = -0.25 * law->share * (u.mean + u_after);
    double own = half * half * (u.square + d.square) + 2.0 * half * (u_share * u.mean + d_share * d.mean);
    own = own + (u_share * u_share + d_share * d_share);
    return 2.0 * law->strength * (own + 0.5 * ((u.mean + u_after) * (d.mean + d_after)));
}

/* cross the blocks of `up`, from the oldest on, with those of `down`, from `below` back to the oldest */
static double pass(ds_line *up, ds_piece *up_ring, ds_line *down, ds_piece *down_ring, int below,
                   const ds_exchange_law *law, int last)
{
    double lost = 0.0;
    int above = up->first;
    for (;;) {
        lost = lost + cross(up, up_ring, above, down, down_ring, below, law, last);
        if (below == down->first) {
            return lost;
        }
        above = ds_exchange_forth(up, up_ring, above);
        below = ds_exchange_back(down, down_ring, below);
    }
}

/* take the integral of the squared wave over the line anew */
static void sum_squares(ds_line *line, const ds_piece *ring)
{
    double total = 0.0;
    int index = line->first;
    for (int i = 0; i < line->count; ++i) {
        total = total + ring[index].square;
        index = ds_ring_next(line, index);
    }
    line->square = total;
    line->square_rest = 0.0;
}

double ds_exchange_all(ds_line *up, ds_piece *up_ring, ds_line *down, ds_piece *down_ring, const ds_exchange_law *law)
{
    const int latest = ds_exchange_newest(down, down_ring);
    double lost = pass(up, up_ring, down, down_ring, ds_exchange_back(down, down_ring, latest), law, 0);
    lost = lost + pass(up, up_ring, down, down_ring, latest, law, 1);
    sum_squares(up, up_ring);
    sum_squares(down, down_ring);
    return lost;
}
