/* The FMU is loaded from its library: its allocations are its own. */
#include "allocation.h"

long allocation_fail(long n)
{
    static long awaited;
    const long left = awaited;
    awaited = n;
    return left;
}

long allocation_live(void)
{
    return 0;
}
