#include "ds_top.h"

void ds_top_start(ds_top *top, double angle)
{
    top->block = 0;
    top->begin = 0.0;
    top->end = 0.0;
    top->incident = DS_NO_PIECE.wave;
    top->outgoing = DS_NO_PIECE.wave;
    top->incoming = DS_NO_PIECE;
    top->angle = angle;
    top->work = 0.0;
    top->driven = 0.0;
    top->slid = 0.0;
}

void ds_top_open(const ds_top_law *law, const ds_clock *clock, ds_top *top, ds_line *up, const ds_piece *up_ring)
{
    if (top->begin >= top->incoming.end) {
        top->incoming = ds_line_pop(up, up_ring);
        top->begin = top->incoming.begin;
    }
    top->end = top->incoming.end;
    const double first = top->incoming.begin;
    const double last = top->incoming.end;
    top->incident = ds_quartic_restrict(top->incoming.wave, (top->begin - first) / (last - first), 1.0);
    double rise;
    const double omega = ds_ramp_at(&top->omega, clock, top->block, top->begin, top->end, &rise);
    top->outgoing.c0 = law->transmission * omega - law->reflection * top->incident.c0;
    top->outgoing.c1 = law->transmission * rise - law->reflection * top->incident.c1;
    top->outgoing.c2 = -law->reflection * top->incident.c2;
    top->outgoing.c3 = -law->reflection * top->incident.c3;
    top->outgoing.c4 = -law->reflection * top->incident.c4;
}

void ds_top_close(const ds_top_law *law, const ds_clock *clock, ds_top *top, ds_line *down, ds_piece *down_ring)
{
    const ds_piece piece = {top->begin, top->end, top->outgoing, 0.0};
    ds_line_push(down, down_ring, piece);
    ds_top_finish(law, clock, top);
}

void ds_top_finish(const ds_top_law *law, const ds_clock *clock, ds_top *top)
{
    const double duration = (top->end - top->begin) * clock->block;
    top->angle += duration * ds_quartic_integral(ds_top_speed(top), 1.0);
    const ds_top_powers powers = ds_top_power_integrals(law, clock, top, 1.0);
    top->work += duration * powers.work;
    top->driven += duration * powers.driven;
    top->slid += duration * powers.slid;
    top->begin = top->end;
    if (top->end >= 1.0) {
        top->block += 1;
        top->begin = 0.0;
        top->incoming = DS_NO_PIECE;
    }
}

int ds_top_cut(ds_top *top, double fraction)
{
    if (!(fraction - top->begin > DS_SNAP)) {
        return 0;
    }
    if (top->end - fraction > DS_SNAP) {
        const double x = (fraction - top->begin) / (top->end - top->begin);
        top->incident = ds_quartic_restrict(top->incident, 0.0, x);
        top->outgoing = ds_quartic_restrict(top->outgoing, 0.0, x);
        top->end = fraction;
    }
    return 1;
}

ds_quartic ds_top_speed(const ds_top *top)
{
    return ds_quartic_add(top->incident, top->outgoing);
}

double ds_top_drive(const ds_clock *clock, const ds_top *top, double x)
{
    double rise;
    const double omega = ds_ramp_at(&top->omega, clock, top->block, top->begin, top->end, &rise);
    return omega + x * rise;
}

double ds_top_torque(const ds_top_law *law, const ds_clock *clock, const ds_top *top, double x)
{
    return law->sliding * (ds_top_drive(clock, top, x) - ds_quartic_value(ds_top_speed(top), x));
}

ds_top_powers ds_top_power_integrals(const ds_top_law *law, const ds_clock *clock, const ds_top *top, double x)
{
    double rise;
    const double omega = ds_ramp_at(&top->omega, clock, top->block, top->begin, top->end, &rise);
    const ds_quartic speed = ds_top_speed(top);
    const ds_quartic drive = {omega, rise, 0.0, 0.0, 0.0};
    const ds_quartic slip = {omega - speed.c0, rise - speed.c1, -speed.c2, -speed.c3, -speed.c4};
    const ds_top_powers powers = {
        law->sliding * ds_quartic_product_integral(slip, speed, x),
        law->sliding * ds_quartic_product_integral(slip, drive, x),
        law->sliding * ds_quartic_product_integral(slip, slip, x),
    };
    return powers;
}
