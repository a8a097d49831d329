#include "readers.h"

#include <stddef.h>
#include <string.h>

#include "calls.h"
#include "guard.h"
#include "laws.h"
#include "operations.h"
#include "plausible.h"

/* ---- tables ---- */

enum { TABLE_STEPS = 4 };

static bool set_friction_table(Run *run, const char *file) {
    const unsigned table = VR_CAM1_FRICTION_TABLE;
    return call_set_texts(run, &table, 1, &file);
}

/* As far as the FMU takes the table: a run with it. Energies are not checked, since a table may hold any numbers. */
void read_table(Bytes in, TableKind kind) {
    static const char file[] = "table.csv";
    Run run;
    const unsigned options = take_byte(&in);
    const uint8_t drives[] = {1, 200, 180, 90, 3, 220, 10, 60, 1, 240, 201, 5, 2, 250, 0, 0};
    write_file(file, in.at, (size_t)(in.end - in.at));
    run_begin(&run, (Bytes){NULL, NULL}, options & 1 ? USE_MODEL_EXCHANGE : USE_CO_SIMULATION, 0);
    REQUIRE(&run, kind == TABLE_GROOVE ? set_groove_table(&run, 0, file) : set_friction_table(&run, file));
    run.wild = true;
    run.in = (Bytes){drives, drives + sizeof drives};
    if (options & 2) set_groove_table(&run, 1, "groove.csv");
    bool goes_on = start(&run);
    if (goes_on) check_values(&run);
    for (int i = 0; i < TABLE_STEPS && goes_on; i++) goes_on = drive(&run);
    if (goes_on) check_values(&run);
    run_end(&run);
}

/* ---- saved states ---- */

/* FNV-1a, 64 bits (G. Fowler, L. Noll, P. Vo). */
static uint64_t fnv1a(const uint8_t *bytes, size_t size) {
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    for (size_t i = 0; i < size; i++) hash = (hash ^ bytes[i]) * UINT64_C(0x100000001b3);
    return hash;
}

static void change_number(Bytes *in, uint8_t *bytes, size_t size) {
    const size_t at = take_word(in) * 4u % size;
    const unsigned kind = take_byte(in);
    const double number = take_any_number(in);
    const size_t width = kind & 1 ? sizeof number : 1;
    const uint8_t byte = (uint8_t)kind;
    if (at + width <= size) memcpy(bytes + at, kind & 1 ? (const void *)&number : &byte, width);
}

static void set_checksum(uint8_t *bytes, size_t size) {
    const uint64_t sum = fnv1a(bytes + sizeof(StateHeader), size - sizeof(StateHeader));
    memcpy(bytes + offsetof(StateHeader, checksum), &sum, sizeof sum);
}

/* A forged state is refused or works, to numbers. */
static void use_forged_state(Run *run, uint8_t *bytes, size_t size) {
    void *forged = NULL;
    if (!call_deserialize(run, bytes, size, &forged)) return;
    if (call_set_state(run, forged)) {
        check_values(run);
        if (drive(run)) check_values(run);
    }
    REQUIRE(run, call_free_state(run, &forged));
}

void read_state(Bytes in) {
    Run run;
    void *state = NULL;
    size_t size = 0;
    const unsigned options = take_byte(&in);
    run_begin(&run, (Bytes){NULL, NULL}, options % USES, 0);
    if (options & 8) set_groove_table(&run, 1, "groove.csv");
    if (options & 16) start(&run);
    REQUIRE(&run, call_get_state(&run, &state) && call_state_size(&run, state, &size));
    uint8_t *bytes = malloc(size);
    REQUIRE(&run, bytes != NULL && call_serialize(&run, state, bytes, size));
    for (unsigned changes = 1 + (options >> 5); changes > 0 && bytes_left(&in); changes--)
        change_number(&in, bytes, size);
    set_checksum(bytes, size);
    run.in = in;
    run.wild = run.forged = true;
    use_forged_state(&run, bytes, size);
    free(bytes);
    REQUIRE(&run, call_free_state(&run, &state));
    run_end(&run);
}
