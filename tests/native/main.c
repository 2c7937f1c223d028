/* The driver of one model's FMU. In every mode a broken law ends the process with a report.
 *
 *   driver random SEED CALLS [LIBRARY]   sequences of the seeds from SEED on, until CALLS calls are made
 *   driver bytes FILE [LIBRARY]          the sequence that the bytes of a file stand for
 *   driver walks OUTPUT [LIBRARY]        the sequences that are written down; every number they see goes to a file
 *   driver cycles COUNT                  lives of instances, and refused ones, after each of which all memory is freed
 *   driver starve                        a life for each of its allocations, which fails in it
 *
 * LIBRARY is that of the FMU, where it is not linked in. Tables are written to the current folder. */
#include <stdlib.h>
#include <string.h>

#include "allocation.h"
#include "sequence.h"
#include "walks.h"

enum { MOST_BYTES = 1 << 20 };

static void run_bytes(session *run, const char *path)
{
    uint8_t *const bytes = malloc(MOST_BYTES);
    FILE *const file = fopen(path, "rb");
    session_begin(run, path, 0);
    REQUIRE(run, bytes != NULL && file != NULL, "cannot be read");
    const size_t n = fread(bytes, 1, MOST_BYTES, file);
    fclose(file);
    sequence_run(run, bytes, n);
    free(bytes);
    printf("%lu calls\n", run->calls);
}

static void run_walks(session *run, const char *path)
{
    run->out = fopen(path, "wb");
    REQUIRE(run, run->out != NULL, "cannot write %s", path);
    walk_all(run);
    fclose(run->out);
}

static void run_cycles(session *run, unsigned long count)
{
    const long live = allocation_live();
    for (unsigned long i = 0; i < count; ++i) {
        session_begin(run, "cycle", i);
        walk_life(run);
        walk_refusals(run);
        REQUIRE(run, allocation_live() == live, "%ld blocks are not freed", allocation_live() - live);
    }
    printf("%lu cycles\n", count);
}

static void run_starve(session *run)
{
    const long live = allocation_live();
    long n = 0;
    do {
        n += 1;
        session_begin(run, "allocation", (unsigned long)n);
        run->starve = n;
        walk_life(run);
        REQUIRE(run, allocation_live() == live, "%ld blocks are not freed", allocation_live() - live);
    } while (run->starve == 0);
    REQUIRE(run, n > 1, "no allocation was seen");
    printf("%ld allocations have failed, each once\n", n - 1);
}

static int run_mode(session *run, int count, char *arguments[])
{
    const char *const mode = arguments[0];
    if (strcmp(mode, "random") == 0 && count > 2) {
        const unsigned long made =
            sequence_run_seeds(run, strtoul(arguments[1], NULL, 10), strtoul(arguments[2], NULL, 10), stdout);
        printf("%lu calls\n", made);
    } else if (strcmp(mode, "bytes") == 0 && count > 1) {
        run_bytes(run, arguments[1]);
    } else if (strcmp(mode, "walks") == 0 && count > 1) {
        run_walks(run, arguments[1]);
    } else if (strcmp(mode, "cycles") == 0 && count > 1) {
        run_cycles(run, strtoul(arguments[1], NULL, 10));
    } else if (strcmp(mode, "starve") == 0) {
        run_starve(run);
    } else {
        fprintf(stderr, "usage: see the head of main.c\n");
        return 2;
    }
    return 0;
}

int main(int count, char *arguments[])
{
    session run = {.table = "table.csv", .name = "start", .call = "none"};
    if (count < 2) {
        fprintf(stderr, "usage: see the head of main.c\n");
        return 2;
    }
    const char *const missing = fmi_bind(&run.fmi, arguments[count - 1]);
    REQUIRE(&run, missing == NULL, "%s of the FMU cannot be loaded", missing);
    return run_mode(&run, count - 1, arguments + 1);
}
