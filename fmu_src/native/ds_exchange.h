/* What the damping along the string makes of two waves that pass through each other. Follows models/plant/exchange.py, which
 * explains it. */
#ifndef DS_EXCHANGE_H
#define DS_EXCHANGE_H

#include "ds_line.h"
#include "ds_linkage.h"

typedef struct {
    double strength; /* 1, kappa = beta h / (4 I), h being the duration of a block */
    double keep;     /* 1, what a wave keeps of itself in a cell */
    double share;    /* 1, what it takes of the mean of the other */
    double decay;    /* 1, what remains of the sum of the means */
} ds_exchange_law;

/* where in the ring the piece after and before that at an index lies */
static inline int ds_ring_next(const ds_line *line, int index)
{
    return index + 1 < line->capacity ? index + 1 : 0;
}

static inline int ds_ring_last(const ds_line *line, int index)
{
    return index > 0 ? index - 1 : line->capacity - 1;
}

DS_SHARED ds_exchange_law ds_exchange_of(double strength);
/* let all blocks of two full lines go on by one block; the energy lost per Z h [rad2/s2] */
DS_SHARED double ds_exchange_all(ds_line *up, ds_piece *up_ring, ds_line *down, ds_piece *down_ring,
                                 const ds_exchange_law *law);
/* where in the ring the newest block begins, and the blocks before and after the one that begins at an index */
DS_SHARED int ds_exchange_newest(const ds_line *line, const ds_piece *ring);
DS_SHARED int ds_exchange_back(const ds_line *line, const ds_piece *ring, int index);
DS_SHARED int ds_exchange_forth(const ds_line *line, const ds_piece *ring, int index);

#endif
