/* What libFuzzer calls with the bytes it makes up. */
#include "sequence.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    session run = {.table = "table.csv"};
    fmi_bind(&run.fmi, NULL);
    session_begin(&run, "input", 0);
    sequence_run(&run, bytes, n);
    return 0;
}
