#include "ds_line.h"

#include <math.h>

#include "ds_clock.h"

#define NEGLIGIBLE 1e-9 /* rad/s, strength of a break folded without being counted, on the default grid */
#define LEAST_NEGLIGIBLE 1e-13 /* rad/s, what it falls to on fine grids, as the fourth power of the block */
#define MOST_NEGLIGIBLE 1e-4   /* rad/s, what it rises to on coarse ones */
#define LEAST_BREAKS 256       /* breaks a queue can hold at least; on fine grids it holds one for each cell */
#define MOST_BREAKS 12.5       /* of these it keeps at most so many in the time of a block of the default grid */
#define DOUBLINGS 40    /* a queue full of breaks keeps only those stronger than the negligible times 2^DOUBLINGS */

static int break_room(int blocks)
{
    return DS_BLOCK * blocks > LEAST_BREAKS ? DS_BLOCK * blocks : LEAST_BREAKS;
}

int ds_line_capacity(int blocks)
{
    return blocks + 2 + break_room(blocks);
}

void ds_line_fill(ds_line *line, ds_piece *ring, int blocks, double level, double coarseness)
{
    const double square = coarseness * coarseness;
    const ds_piece piece = {0.0, 1.0, {level, 0.0, 0.0, 0.0, 0.0}, level * level};
    line->capacity = ds_line_capacity(blocks);
    const double most = fmax(DS_BLOCK * blocks, 1.0 + MOST_BREAKS * (coarseness * blocks));
    line->break_limit = (int)fmin(break_room(blocks), most);
    for (int i = 0; i < line->capacity; ++i) {
        ring[i] = piece;
    }
    line->negligible = fmin(fmax(NEGLIGIBLE * (square * square), LEAST_NEGLIGIBLE), MOST_NEGLIGIBLE);
    line->first = 0;
    line->count = blocks;
    line->breaks = 0;
    line->folded = 0;
    line->square = blocks * (level * level);
    line->square_rest = 0.0;
    line->folded_square = 0.0;
    line->left = 0;
    line->kept = 0;
}

/* add to the integral of the square without losing what the sum cannot hold (Neumaier) */
static void add(ds_line *line, double amount)
{
    const double total = line->square + amount;
    if (fabs(line->square) >= fabs(amount)) {
        line->square_rest += (line->square - total) + amount;
    } else {
        line->square_rest += (amount - total) + line->square;
    }
    line->square = total;
}

double ds_line_threshold(const ds_line *line)
{
    if (line->breaks >= line->break_limit) {
        return 1e300;
    }
    const int doublings = (2 * DOUBLINGS * line->breaks) / line->break_limit - DOUBLINGS;
    return doublings > 0 ? ldexp(line->negligible, doublings) : line->negligible;
}

/* fold a piece into the last one if the break between them is weak; say whether it was done */
static int fold(ds_line *line, ds_piece *ring, ds_piece piece)
{
    int index = line->first + line->count - 1;
    if (line->count == 0) {
        return 0;
    }
    if (index >= line->capacity) {
        index -= line->capacity;
    }
    ds_piece *const last = &ring[index];
    if (last->end != piece.begin) {
        return 0;
    }
    const double length = piece.end - last->begin;
    const double limit = ds_line_threshold(line);
    double strength;
    ds_quartic merged = ds_quartic_merge(last->wave, piece.wave, (last->end - last->begin) / length, limit, &strength);
    if (strength > limit) {
        return 0;
    }
    if (strength > line->negligible) {
        /* the projection of the two pieces: it adds no energy, and the bit's collocation follows a cubic exactly */
        merged = ds_quartic_flatten(merged);
        line->folded += 1;
    }
    const double former = last->square;
    const double square = length * ds_quartic_square_integral(merged);
    const double added = (piece.end - last->end) * ds_quartic_square_integral(piece.wave);
    last->end = piece.end;
    last->wave = merged;
    last->square = square;
    add(line, square - former);
    line->folded_square += (former - square) + added;
    return 1;
}

void ds_line_push(ds_line *line, ds_piece *ring, ds_piece piece)
{
    if (piece.begin > 0.0 && fold(line, ring, piece)) {
        return;
    }
    int index = line->first + line->count;
    if (index >= line->capacity) {
        index -= line->capacity;
    }
    piece.square = (piece.end - piece.begin) * ds_quartic_square_integral(piece.wave);
    if (line->left > 0) {
        ring[2 * line->capacity + index] = ring[index];
        line->left -= 1;
    }
    ring[index] = piece;
    line->count += 1;
    if (piece.begin > 0.0) {
        line->breaks += 1;
    }
    add(line, piece.square);
}

ds_piece ds_line_pop(ds_line *line, const ds_piece *ring)
{
    const ds_piece piece = ring[line->first];
    line->first += 1;
    if (line->first >= line->capacity) {
        line->first = 0;
    }
    line->count -= 1;
    if (piece.begin > 0.0) {
        line->breaks -= 1;
    }
    add(line, -piece.square);
    return piece;
}

/* the place in the ring so many after the oldest piece, or one before it */
static int place_after(const ds_line *line, int count)
{
    const int place = line->first + count;
    if (place < 0) {
        return place + line->capacity;
    }
    return place >= line->capacity ? place - line->capacity : place;
}

void ds_line_keep(ds_line *line, ds_piece *ring)
{
    /* a fold changes the newest piece, and pushes overwrite one place after the other from there on */
    const int newest = place_after(line, line->count - 1);
    ring[2 * line->capacity + newest] = ring[newest];
    line->left = line->capacity - 1;
    line->kept = 0;
}

void ds_line_keep_all(ds_line *line, ds_piece *ring, const ds_line *before)
{
    const int free_places = line->capacity - before->count;
    const int pushed = line->capacity - 1 - line->left;
    if (line->kept) {
        return;
    }
    for (int i = pushed > free_places ? pushed - free_places : 0; i < before->count - 1; ++i) {
        const int index = place_after(before, i);
        ring[2 * line->capacity + index] = ring[index];
    }
    line->left = free_places > pushed ? free_places - pushed : 0;
    line->kept = 1;
}

void ds_line_put_back(const ds_line *line, ds_piece *ring, const ds_line *before)
{
    const int free_places = line->capacity - before->count;
    const int first = line->kept ? 0 : before->count - 1;
    const int end = line->kept ? before->count + free_places - line->left : before->count + line->capacity - 1 - line->left;
    for (int i = first; i < end; ++i) {
        const int index = place_after(before, i);
        ring[index] = ring[2 * line->capacity + index];
    }
}
