/* A wave under way between the ends of the string: a queue of quartic pieces, one travel time long.
 * Follows models/plant/delay_line.py, which explains it. */
#ifndef DS_LINE_H
#define DS_LINE_H

#include "ds_linkage.h"
#include "ds_quartic.h"

typedef struct {
    double begin; /* 1, fraction of the block, in [0, 1) */
    double end;   /* 1, fraction of the block, in (0, 1] */
    ds_quartic wave; /* rad/s, the wave between them */
    double square;   /* rad2/s2 blocks, integral of its square */
} ds_piece;

static const ds_piece DS_NO_PIECE = {0.0, 0.0, {0.0, 0.0, 0.0, 0.0, 0.0}, 0.0};

typedef struct {
    int capacity;         /* 1, pieces the ring can hold */
    int break_limit;      /* 1, pieces that may begin inside a block */
    int first;            /* 1, index of the oldest piece */
    int count;            /* 1, pieces in the queue */
    int breaks;           /* 1, of these, pieces that begin inside a block */
    int folded;           /* 1, breaks folded although they were not negligible */
    double negligible;    /* rad/s, strength below which a break is folded without being counted */
    double square;        /* rad2/s2 blocks, integral of the squared wave over the queue */
    double square_rest;   /* rad2/s2 blocks, its compensation */
    double folded_square; /* rad2/s2 blocks, what the folds took from it */
    int left;             /* 1, places of the ring that pushes of this step would overwrite without their being kept */
    int kept;             /* 1, all that was in the queue when the step began is kept */
} ds_line;

DS_SHARED int ds_line_capacity(int blocks);
DS_SHARED void ds_line_fill(ds_line *line, ds_piece *ring, int blocks, double level, double coarseness);
/* append a piece, whose `square` is computed here, or fold it into the last */
DS_SHARED void ds_line_push(ds_line *line, ds_piece *ring, ds_piece piece);
/* strength a break must exceed to be kept [rad/s]: the fuller the queue, the greater */
DS_SHARED double ds_line_threshold(const ds_line *line);
DS_SHARED ds_piece ds_line_pop(ds_line *line, const ds_piece *ring);

/* Two capacities behind its ring a line has another, where it keeps what a step overwrites, so that a step which is
 * refused leaves no trace. `before` is the line as it was when the step began. */

/* begin to keep */
DS_SHARED void ds_line_keep(ds_line *line, ds_piece *ring);
/* keep all that is in the queue, because all of it is about to change */
DS_SHARED void ds_line_keep_all(ds_line *line, ds_piece *ring, const ds_line *before);
/* put back what is kept; the line itself is for the caller to put back */
DS_SHARED void ds_line_put_back(const ds_line *line, ds_piece *ring, const ds_line *before);

#endif
