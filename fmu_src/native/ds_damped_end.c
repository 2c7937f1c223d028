#include "ds_damped_end.h"

#include "ds_exchange.h"

#define SUBSTITUTIONS 8

void ds_damped_end_start(ds_damped_end *end)
{
    end->raw = DS_NO_PIECE;
    end->following = 0.0;
    end->sent = 0.0;
    end->square = 0.0;
    end->settled = 0.0;
}

void ds_damped_end_take(ds_damped_end *end, ds_line *line, const ds_piece *ring)
{
    end->raw = ds_line_pop(line, ring);
    end->following = 0.0;
    int index = line->first;
    for (double last = end->raw.end; last < 1.0; index = ds_ring_next(line, index)) {
        const ds_piece *const piece = &ring[index];
        last = piece->end;
        end->following = end->following + (piece->end - piece->begin) * ds_quartic_integral(piece->wave, 1.0);
    }
}

/* a part of the piece as it was before it met what the end sends */
static ds_quartic raw_wave(const ds_damped_end *end, double begin, double finish)
{
    const double first = end->raw.begin;
    const double last = end->raw.end;
    return ds_quartic_restrict(end->raw.wave, (begin - first) / (last - first), (finish - first) / (last - first));
}

double ds_damped_end_wave(const ds_damped_end *end, double begin)
{
    return raw_wave(end, begin, end->raw.end).c0;
}

/* the mean of two waves */
static ds_quartic between(ds_quartic a, ds_quartic b)
{
    const ds_quartic m = {0.5 * (a.c0 + b.c0), 0.5 * (a.c1 + b.c1), 0.5 * (a.c2 + b.c2), 0.5 * (a.c3 + b.c3),
                          0.5 * (a.c4 + b.c4)};
    return m;
}

ds_piece ds_damped_end_incident(const ds_damped_end *end, double strength, double begin, ds_sending sending)
{
    const double length = end->raw.end - begin;
    const double echo = sending.echo;
    const ds_quartic q = raw_wave(end, begin, end->raw.end);
    ds_piece piece = {begin, end->raw.end, q, 0.0};
    ds_quartic *const y = &piece.wave;
    for (int i = 0; i < SUBSTITUTIONS; ++i) {
        const ds_quartic m = between(q, *y);
        const double bend = 0.5 * strength * ((1.0 + echo) * y->c0 + sending.level);
        const double s0 = sending.level + echo * y->c0;
        const double s1 = sending.rise + echo * y->c1;
        const double s2 = echo * y->c2;
        const double s3 = echo * y->c3;
        y->c0 = q.c0 - strength * (begin * m.c0 + end->sent - bend * (begin * begin));
        y->c1 = q.c1 - strength * (begin * m.c1 + length * (m.c0 + s0) - 2.0 * bend * (begin * length));
        y->c2 = q.c2 - strength * (begin * m.c2 + length * (m.c1 + 0.5 * s1) - bend * (length * length));
        y->c3 = q.c3 - strength * (begin * m.c3 + length * (m.c2 + DS_THIRD * s2));
        y->c4 = q.c4 - strength * (begin * m.c4 + length * (m.c3 + 0.25 * s3));
    }
    return piece;
}

ds_quartic ds_damped_end_outgoing(ds_damped_end *end, double strength, const ds_end_piece *piece)
{
    const double begin = piece->begin;
    const double length = piece->end - begin;
    const ds_quartic sent = piece->sent;
    const double last = end->raw.end;
    const double rest = end->following + (last - begin) * ds_quartic_integral(raw_wave(end, begin, last), 1.0);
    const ds_quartic q = raw_wave(end, begin, piece->end);
    const double after = 1.0 - begin;
    const double bend = strength * piece->speed.c0;
    ds_quartic d = sent;
    for (int i = 0; i < SUBSTITUTIONS; ++i) {
        const ds_quartic m = between(sent, d);
        d.c0 = sent.c0 - strength * (after * m.c0 + rest - bend * (begin * after));
        d.c1 = sent.c1 - strength * (after * m.c1 - length * (m.c0 + q.c0) - bend * (length * (after - begin)));
        d.c2 = sent.c2 - strength * (after * m.c2 - length * (m.c1 + 0.5 * q.c1) + bend * (length * length));
        d.c3 = sent.c3 - strength * (after * m.c3 - length * (m.c2 + DS_THIRD * q.c2));
        d.c4 = sent.c4 - strength * (after * m.c4 - length * (m.c3 + 0.25 * q.c3));
    }
    const double turned = ds_quartic_square_integral(piece->speed);
    const double change = (ds_quartic_square_integral(q) - ds_quartic_square_integral(piece->incident)) +
                          (ds_quartic_square_integral(sent) - ds_quartic_square_integral(d));
    const int goes_on = piece->end < 1.0;
    end->square = end->square + length * turned;
    end->settled = goes_on ? end->settled + length * (change - strength * turned) : 0.0;
    end->sent = goes_on ? end->sent + length * ds_quartic_integral(sent, 1.0) : 0.0;
    return d;
}

double ds_damped_end_square(const ds_damped_end *end, const ds_end_piece *piece, double x)
{
    return end->square + (piece->end - piece->begin) * ds_quartic_product_integral(piece->speed, piece->speed, x);
}

double ds_damped_end_settled(const ds_damped_end *end, double strength, const ds_end_piece *piece, double x)
{
    const ds_quartic q = raw_wave(end, piece->begin, piece->end);
    const double change = ds_quartic_product_integral(q, q, x) -
                          ds_quartic_product_integral(piece->incident, piece->incident, x);
    const double turned = ds_quartic_product_integral(piece->speed, piece->speed, x);
    return end->settled + (piece->end - piece->begin) * (change - strength * turned);
}
