/* The fuzz target. The first byte of an input chooses what the rest is for:
 *   calls for co-simulation, model exchange, or co-simulation with event mode;
 *   the text of a groove table or of a friction table;
 *   changes of the bytes of a saved state. */
#include "operations.h"
#include "plausible.h"
#include "readers.h"

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerInitialize(int *argc, char ***argv) {
    (void)argc, (void)argv;
    write_tables();
    return 0;
}

static void make_run(Bytes in, Use use) {
    Run run;
    const unsigned options = take_byte(&in);
    run_begin(&run, in, use, options);
    make_calls(&run);
    run_end(&run);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    Bytes in = {data, data + size};
    const unsigned choice = take_below(&in, 16);
    if (choice < 5) make_run(in, USE_CO_SIMULATION);
    else if (choice < 9) make_run(in, USE_MODEL_EXCHANGE);
    else if (choice < 13) make_run(in, USE_HYBRID);
    else if (choice < 15) read_table(in, choice == 13 ? TABLE_GROOVE : TABLE_FRICTION);
    else read_state(in);
    return 0;
}
