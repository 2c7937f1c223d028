/* The allocations an FMU makes, counted and made to fail; to open a file is one. Where the FMU is not linked in, none
 * are seen. */
#ifndef ALLOCATION_H
#define ALLOCATION_H

/* let the n-th allocation of this thread from here on fail, 1 the next; 0 lets none fail. Returns the n that is left of
 * the last call, 0 if that allocation has failed or none was to */
long allocation_fail(long n);
/* blocks this thread has allocated and not freed */
long allocation_live(void);

#endif
