/* Stands before malloc, calloc, realloc, free and fopen of an FMU that is linked with --wrap of each. */
#include <stdio.h>

#include "allocation.h"

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *block, size_t size);
void __real_free(void *block);
FILE *__real_fopen(const char *path, const char *mode);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *block, size_t size);
void __wrap_free(void *block);
FILE *__wrap_fopen(const char *path, const char *mode);

static __thread long fails_in;
static __thread long live;

long allocation_fail(long n)
{
    const long left = fails_in;
    fails_in = n;
    return left;
}

long allocation_live(void)
{
    return live;
}

/* whether the allocation at hand is the one that fails */
static int fails(void)
{
    if (fails_in == 0) {
        return 0;
    }
    fails_in -= 1;
    return fails_in == 0;
}

void *__wrap_malloc(size_t size)
{
    void *const block = fails() ? NULL : __real_malloc(size);
    live += block != NULL;
    return block;
}

void *__wrap_calloc(size_t count, size_t size)
{
    void *const block = fails() ? NULL : __real_calloc(count, size);
    live += block != NULL;
    return block;
}

void *__wrap_realloc(void *block, size_t size)
{
    void *const moved = fails() ? NULL : __real_realloc(block, size);
    live += block == NULL && moved != NULL;
    return moved;
}

void __wrap_free(void *block)
{
    live -= block != NULL;
    __real_free(block);
}

FILE *__wrap_fopen(const char *path, const char *mode)
{
    return fails() ? NULL : __real_fopen(path, mode);
}
