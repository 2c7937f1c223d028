/* A place along the string where speed, torque and angle are read: where two blocks begin to cross at whole blocks.
 * Follows models/plant/station.py, which explains it. */
#ifndef DS_STATION_H
#define DS_STATION_H

#include "ds_line.h"
#include "ds_linkage.h"

typedef struct {
    double up;     /* rad/s, the up-going wave there */
    double down;   /* rad/s, the down-going wave there */
    double turned; /* rad/s blocks, integral of their sum since the begin of the block */
} ds_station_reading;

/* read at a fraction of the block where the blocks that begin at `above` and `below` of the rings cross;
 * `strength` is kappa */
DS_SHARED ds_station_reading ds_station_read(const ds_line *up, const ds_piece *up_ring, int above, const ds_line *down,
                                             const ds_piece *down_ring, int below, double fraction, double strength);
/* derivatives by time of the two waves there; the reading's `turned` is not used */
DS_SHARED ds_station_reading ds_station_rate(const ds_line *up, const ds_piece *up_ring, int above, const ds_line *down,
                                             const ds_piece *down_ring, int below, double fraction, double strength);

#endif
