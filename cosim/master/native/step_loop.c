/* The explicit steps of a run with known communication points, at the speed of C.
 *
 * What `readable_steps` does for one row, this does for many, in the same order: for each component its inputs
 * are gathered from what others have put out, set, the component steps, and its outputs are got straight into the
 * recording. Everything is laid out by Python beforehand (cosim/master/compiled_loop.py); nothing is allocated here. */
#include <stddef.h>
#include <string.h>

#if defined(_WIN32)
#define STEP_API __declspec(dllexport)
#else
#define STEP_API __attribute__((visibility("default")))
#endif

enum { FMI2_WARNING = 1, FMI2_TRUE = 1 };

/* one number that a connection brings; row k of the target is row k - lag of the source */
typedef struct {
    const char *source;   /* in row 0 */
    char *target;         /* in row 0 */
    size_t source_stride; /* bytes from row to row */
    size_t target_stride;
    size_t size; /* bytes */
    size_t lag;  /* rows */
} step_link;

/* one number that a connection brings in another form: times a factor, plus an offset, or by a table of integers */
typedef struct {
    step_link link;
    double factor;
    double offset;
    const int *table; /* pairs of what is given and what is taken for it; NULL: factor and offset, of doubles */
    size_t pairs;
} step_conversion;

/* a getter or setter of FMI 2.0 (section 2.1.7) and the values it exchanges */
typedef struct {
    int (*call)(void *component, const unsigned references[], size_t count, void *values);
    const unsigned *references;
    size_t count;
    char *values;  /* in row 0 */
    size_t stride; /* bytes from row to row */
} step_exchange;

/* fmi2SetRealInputDerivatives or fmi2GetRealOutputDerivatives (section 4.2.1) */
typedef struct {
    int (*call)(void *component, const unsigned references[], size_t count, const int orders[], void *values);
    const unsigned *references;
    size_t count;
    const int *orders;
    char *values;
    size_t stride;
} step_slopes;

typedef struct {
    void *component;
    int (*do_step)(void *component, double time, double size, int no_set_state_prior);
    const step_link *links;
    size_t link_count;
    const step_conversion *conversions;
    size_t conversion_count;
    const step_exchange *writes;
    size_t write_count;
    const step_exchange *reads;
    size_t read_count;
    const step_slopes *input_slopes;  /* NULL: none */
    const step_slopes *output_slopes; /* NULL: none */
} step_node;

enum { STEP_WRITE, STEP_INPUT_SLOPES, STEP_DO_STEP, STEP_READ, STEP_OUTPUT_SLOPES };

/* the call that failed */
typedef struct {
    size_t row;
    size_t node;
    int phase;    /* of the enumeration above */
    size_t index; /* of the exchange */
    int status;   /* fmi2Status */
} step_failure;

static void convert(const step_conversion *conversion, size_t row)
{
    const step_link *const link = &conversion->link;
    const char *const source = link->source + (row - link->lag) * link->source_stride;
    char *const target = link->target + row * link->target_stride;
    if (conversion->table == NULL) {
        double value;
        memcpy(&value, source, sizeof value);
        value = conversion->factor * value + conversion->offset;
        memcpy(target, &value, sizeof value);
        return;
    }
    int value;
    memcpy(&value, source, sizeof value);
    for (size_t i = 0; i < conversion->pairs; ++i) {
        if (conversion->table[2 * i] == value) {
            value = conversion->table[2 * i + 1];
            break;
        }
    }
    memcpy(target, &value, sizeof value);
}

static void gather(const step_node *node, size_t row)
{
    for (size_t i = 0; i < node->link_count; ++i) {
        const step_link *const link = &node->links[i];
        memcpy(link->target + row * link->target_stride, link->source + (row - link->lag) * link->source_stride,
               link->size);
    }
    for (size_t i = 0; i < node->conversion_count; ++i) {
        convert(&node->conversions[i], row);
    }
}

static int exchange_slopes(const step_node *node, const step_slopes *slopes, size_t row)
{
    return slopes == NULL ? 0
                          : slopes->call(node->component, slopes->references, slopes->count, slopes->orders,
                                         slopes->values + row * slopes->stride);
}

/* do all getters or setters; *index: the one that failed */
static int exchange(const step_node *node, const step_exchange exchanges[], size_t count, size_t row, size_t *index)
{
    for (*index = 0; *index < count; ++*index) {
        const step_exchange *const e = &exchanges[*index];
        const int status = e->call(node->component, e->references, e->count, e->values + row * e->stride);
        if (status != 0 && status != FMI2_WARNING) {
            return status;
        }
    }
    return 0;
}

/* take one component to the communication point of a row; the status that ended it, or 0 */
static int step_component(const step_node *node, size_t row, double time, double size, step_failure *failure)
{
    gather(node, row);
    failure->phase = STEP_WRITE;
    int status = exchange(node, node->writes, node->write_count, row, &failure->index);
    if (status == 0) {
        failure->phase = STEP_INPUT_SLOPES;
        status = exchange_slopes(node, node->input_slopes, row);
    }
    if (status == 0 || status == FMI2_WARNING) {
        failure->phase = STEP_DO_STEP;
        status = node->do_step(node->component, time, size, FMI2_TRUE);
    }
    if (status == 0 || status == FMI2_WARNING) {
        failure->phase = STEP_READ;
        status = exchange(node, node->reads, node->read_count, row, &failure->index);
    }
    if (status == 0) {
        failure->phase = STEP_OUTPUT_SLOPES;
        status = exchange_slopes(node, node->output_slopes, row);
    }
    return status == FMI2_WARNING ? 0 : status;
}

/* Take all components through the steps that end in the rows first to last; times[k] and sizes[k] are those of the step
 * from row k. 0, or the status of the call that failed, which *failure names. */
STEP_API int step_rows(const step_node nodes[], size_t count, const double times[], const double sizes[], size_t first,
                       size_t last, step_failure *failure)
{
    for (size_t row = first; row <= last; ++row) {
        for (size_t i = 0; i < count; ++i) {
            const int status = step_component(&nodes[i], row, times[row - 1], sizes[row - 1], failure);
            if (status != 0) {
                failure->row = row;
                failure->node = i;
                failure->status = status;
                return status;
            }
        }
    }
    return 0;
}
