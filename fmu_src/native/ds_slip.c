#include "ds_slip.h"

#include <math.h>

#include "ds_collocation.h"

#define TRUNCATION 1e-6        /* rad/s, or if a quartic does not follow the speed closer; on the default grid */
#define LEAST_TRUNCATION 1e-10 /* rad/s, what this falls to on fine grids, as the sixth power of the block */
#define MOST_TRUNCATION 0.1    /* rad/s, and rises to on coarse ones */
#define GLANCE 0.1       /* 1, work of finding at its begin that a piece is too rough, in blocks */
#define COLLOCATION 0.35 /* 1, work of a collocation beside the steps of Newton's method */
#define NEWTON_WORK 0.15 /* 1, work of one of them */
#define NEWTON_STEPS 12        /* most Newton steps of a piece; one or two are usual */
#define NEWTON_LIMIT 3e-6      /* rad/s, correction after which no further step is taken, as the next would be about
                                * its square; default grid, it changes as the square of the block */

/* what holds at a point of a piece at a speed */
typedef struct {
    double value;      /* rad/s, dv/dx */
    double derivative; /* 1, of dv/dx by the speed */
    double dry;        /* N m, dry friction */
    double dry_slope;  /* N m s/rad, its derivative by the speed */
} slip_point;

/* the equations of collocation at the three points after the first, and what solves them */
typedef struct {
    double speed[4];    /* rad/s */
    double slope[4];    /* rad/s */
    double jacobian[4]; /* 1, derivative of the slope by the speed */
    double dry[4];      /* N m */
} slip_unknowns;

/* the drive and the weight at the four points, and what is the same in all of them */
typedef struct {
    const ds_bit_law *law;
    int direction;
    double scale;     /* s/(kg m2), h / I_B */
    double drive[4];  /* N m, torque of the incident wave */
    double weight[4]; /* N */
} slip_piece;

ds_accuracy ds_accuracy_on(const ds_clock *clock)
{
    const double coarseness = ds_clock_coarseness(clock);
    const double square = coarseness * coarseness;
    const double truncation = TRUNCATION * (square * square * square);
    const ds_accuracy accuracy = {fmin(fmax(truncation, LEAST_TRUNCATION), MOST_TRUNCATION), NEWTON_LIMIT * square};
    return accuracy;
}

static slip_point at_point(const slip_piece *p, int i, double speed)
{
    const ds_bit_law *const law = p->law;
    const ds_friction_point friction = ds_friction_at(&law->friction, p->weight[i], p->direction * speed);
    const double dry = friction.torque * p->direction;
    const slip_point s = {
        p->scale * (p->drive[i] - law->damping * speed - dry),
        p->scale * (-friction.slope - law->damping),
        dry,
        friction.slope,
    };
    return s;
}

static double greater(double a, double b)
{
    return b > a ? b : a; /* as max of Python, which keeps the first of equals */
}

/* integral of torque times speed over the piece */
static double slip_power(const ds_bit_law *law, const slip_unknowns *u)
{
    double total = 0.0;
    for (int i = 0; i < 4; ++i) {
        total = total + ds_weights[i] * ((law->viscosity * u->speed[i] + u->dry[i]) * u->speed[i]);
    }
    return total;
}

/* solve the equations of collocation by Newton's method, and return the steps taken; u holds what is known at the begin,
 * and the guessed speeds */
static int solve_slip(const slip_piece *p, double limit, slip_unknowns *u)
{
    int step = 0;
    while (step < NEWTON_STEPS) {
        ++step;
        double residual[3];
        double d[3];
        double dry_slope[4];
        for (int i = 1; i < 4; ++i) {
            const slip_point s = at_point(p, i, u->speed[i]);
            u->slope[i] = s.value;
            u->jacobian[i] = s.derivative;
            u->dry[i] = s.dry;
            dry_slope[i] = s.dry_slope;
        }
        ds_collocation_values(u->speed[0], u->slope, residual);
        for (int i = 0; i < 3; ++i) {
            residual[i] = residual[i] - u->speed[i + 1];
        }
        ds_collocation_correction(residual, &u->jacobian[1], d);
        for (int i = 1; i < 4; ++i) {
            u->speed[i] = u->speed[i] + d[i - 1];
            u->slope[i] = u->slope[i] + u->jacobian[i] * d[i - 1];
            u->dry[i] = u->dry[i] + dry_slope[i] * d[i - 1];
        }
        if (fabs(d[0]) <= limit && fabs(d[1]) <= limit && fabs(d[2]) <= limit) {
            break;
        }
    }
    return step;
}

/* guess the speeds, with a friction that changes as at the begin */
static void guess_slip(const slip_piece *p, ds_quartic incident, slip_unknowns *u)
{
    const double push = p->scale * p->law->twice_impedance;
    const double bend = 0.5 * (u->jacobian[0] * u->slope[0] + push * incident.c1);
    const double t0 = DS_THIRD * push * incident.c2;
    const double t1 = 0.25 * push * incident.c3;
    const double t2 = 0.2 * push * incident.c4;
    for (int i = 1; i < 4; ++i) {
        const double x = ds_nodes[i];
        u->speed[i] = u->speed[0] + x * (u->slope[0] + x * (bend + x * (t0 + x * (t1 + x * t2))));
    }
}

ds_slip ds_slip_collocate(const ds_bit_law *law, const ds_accuracy *accuracy, int direction, double duration,
                          double start, ds_quartic incident, ds_wob wob, int last_try)
{
    slip_piece p = {law, direction, duration / law->inertia, {0.0}, {0.0}};
    for (int i = 0; i < 4; ++i) {
        p.drive[i] = law->twice_impedance * ds_quartic_value(incident, ds_nodes[i]);
        p.weight[i] = wob.weight + ds_nodes[i] * wob.rise;
    }
    const slip_point first = at_point(&p, 0, start);
    ds_slip slip = {{0.0, 0.0, 0.0, 0.0, 0.0}, 0.0, fabs(first.derivative) / DS_GREATEST_STIFFNESS, GLANCE};
    if (slip.roughness > 1.0 && !last_try) {
        return slip;
    }
    /* by rounding it may seem to slip back at a release, but there the friction is overcome */
    const double g = start == 0.0 && first.value * direction < 0.0 ? 0.0 : first.value;
    slip_unknowns u = {{start, 0.0, 0.0, 0.0}, {g, 0.0, 0.0, 0.0}, {first.derivative, 0.0, 0.0, 0.0},
                  {first.dry, 0.0, 0.0, 0.0}};
    guess_slip(&p, incident, &u);
    slip.work = COLLOCATION + NEWTON_WORK * solve_slip(&p, accuracy->newton, &u);
    slip.speed = ds_antiderivative(start, u.slope);
    slip.power = slip_power(law, &u);
    const double *const j = u.jacobian;
    const double stiffest = greater(greater(greater(fabs(j[0]), fabs(j[1])), fabs(j[2])), fabs(j[3]));
    const double truncation = fabs(slip.speed.c4) * (stiffest + law->friction.rate * fabs(u.speed[3] - start));
    slip.roughness = greater(stiffest / DS_GREATEST_STIFFNESS, truncation / accuracy->truncation);
    return slip;
}
