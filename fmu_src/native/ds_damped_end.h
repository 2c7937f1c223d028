/* The damping next to an end of the string, where the outgoing wave crosses the incident one it was made of.
 * Follows models/plant/damped_end.py, which explains it. */
#ifndef DS_DAMPED_END_H
#define DS_DAMPED_END_H

#include "ds_line.h"
#include "ds_linkage.h"

typedef struct {
    ds_piece raw;     /* rad/s, the incident piece, as it was before it met what the end sends */
    double following; /* rad/s blocks, integral of the wave over the rest of the block after `raw` */
    double sent;      /* rad/s blocks, integral of what the end has sent since the begin of the block */
    double square;    /* rad2/s2 blocks, integral of the squared speed of the end */
    double settled;   /* rad2/s2 blocks, what the pieces of this block change in the integral of the squared waves */
} ds_damped_end;

/* what an end sends: `echo` times the incident wave, and a straight line of its own */
typedef struct {
    double echo;  /* 1 */
    double level; /* rad/s, at the begin */
    double rise;  /* rad/s, to the end of the piece */
} ds_sending;

/* a piece of the end's motion */
typedef struct {
    double begin;       /* 1, fraction of the block */
    double end;         /* 1 */
    ds_quartic incident; /* rad/s, the incident wave */
    ds_quartic sent;     /* rad/s, what the end sends */
    ds_quartic speed;    /* rad/s, the speed of the end */
} ds_end_piece;

DS_SHARED void ds_damped_end_start(ds_damped_end *end);
/* take the next piece out of the line */
DS_SHARED void ds_damped_end_take(ds_damped_end *end, ds_line *line, const ds_piece *ring);
/* the wave at a place of the piece, as it was before it met what the end sends */
DS_SHARED double ds_damped_end_wave(const ds_damped_end *end, double begin);
/* the incident piece from `begin` on, while the end sends; `strength` is kappa */
DS_SHARED ds_piece ds_damped_end_incident(const ds_damped_end *end, double strength, double begin, ds_sending sending);
/* the outgoing wave that the sent one becomes on a piece; counts the piece */
DS_SHARED ds_quartic ds_damped_end_outgoing(ds_damped_end *end, double strength, const ds_end_piece *piece);
/* `square` and `settled` at x of a piece that is not counted yet */
DS_SHARED double ds_damped_end_square(const ds_damped_end *end, const ds_end_piece *piece, double x);
DS_SHARED double ds_damped_end_settled(const ds_damped_end *end, double strength, const ds_end_piece *piece, double x);

#endif
