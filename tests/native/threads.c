/* Instances in threads: every thread makes its own sequences, at the same time as the others and once more alone; what
 * it sees is the same.
 *
 *   threads COUNT SEED CALLS */
#include <pthread.h>
#include <stdlib.h>

#include "sequence.h"

enum { MOST_THREADS = 16 };

typedef struct {
    session run;
    char table[32];
    unsigned long seed;
    unsigned long calls;
    FILE *report; /* a digest of every sequence */
} task;

static void *work(void *argument)
{
    task *const t = argument;
    sequence_run_seeds(&t->run, t->seed, t->calls, t->report);
    rewind(t->report);
    return NULL;
}

static task new_task(unsigned long number, unsigned long seed, unsigned long calls)
{
    task t = {.seed = seed + 1000 * number, .calls = calls};
    fmi_bind(&t.run.fmi, NULL);
    snprintf(t.table, sizeof t.table, "table-%lu.csv", number);
    t.report = tmpfile();
    return t;
}

/* whether two reports read the same; closes them */
static int are_same(FILE *one, FILE *other)
{
    int a;
    int b;
    do {
        a = getc(one);
        b = getc(other);
    } while (a == b && a != EOF);
    fclose(one);
    fclose(other);
    return a == b;
}

int main(int count, char *arguments[])
{
    static task tasks[MOST_THREADS];
    static task alone[MOST_THREADS];
    pthread_t threads[MOST_THREADS];
    if (count < 4) {
        return 2;
    }
    const unsigned long most = strtoul(arguments[1], NULL, 10);
    const unsigned long n = most < MOST_THREADS ? most : MOST_THREADS;
    for (unsigned long i = 0; i < n; ++i) {
        tasks[i] = new_task(i, strtoul(arguments[2], NULL, 10), strtoul(arguments[3], NULL, 10));
        alone[i] = new_task(i, strtoul(arguments[2], NULL, 10), strtoul(arguments[3], NULL, 10));
        tasks[i].run.table = tasks[i].table;
        alone[i].run.table = tasks[i].table;
    }
    for (unsigned long i = 0; i < n; ++i) {
        pthread_create(&threads[i], NULL, work, &tasks[i]);
    }
    for (unsigned long i = 0; i < n; ++i) {
        pthread_join(threads[i], NULL);
    }
    for (unsigned long i = 0; i < n; ++i) {
        work(&alone[i]);
        REQUIRE(&alone[i].run, are_same(tasks[i].report, alone[i].report), "other results than beside other threads");
    }
    printf("%lu threads\n", n);
    return 0;
}
