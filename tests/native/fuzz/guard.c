#include "guard.h"

#include <math.h>
#include <string.h>

void *guard_bytes_of(Run *run, void *state, size_t *size) {
    *size = raw_state_size(run, state);
    void *bytes = malloc(*size);
    REQUIRE(run, bytes != NULL && raw_serialize(run, state, bytes, *size));
    return bytes;
}

/* Compares the memory behind both pointers, which is what the bytes hold behind their header: to serialize would take
 * most of the time of a run. */
bool guard_same(Run *run, void *state, void *other) {
    return memcmp(state, other, raw_state_size(run, state) - sizeof(StateHeader)) == 0;
}

Guard guard_begin(Run *run) {
    const Guard guard = {run->messages, run->explained, !run->inside};
    if (guard.saved) REQUIRE(run, raw_get_state(run, &run->before));
    return guard;
}

static void check_unchanged(Run *run) {
    void *after = NULL;
    REQUIRE(run, raw_get_state(run, &after));
    REQUIRE(run, guard_same(run, run->before, after));
    REQUIRE(run, raw_free_state(run, &after));
}

bool guard_end(Run *run, Guard guard, bool ok) {
    if (!ok) run->explained++;
    const int explained = run->explained - guard.explained, messages = run->messages - guard.messages;
    REQUIRE(run, messages == (run->logs ? explained : 0));
    if (!ok && run->logs) REQUIRE(run, run->message[0] != '\0');
    if (!ok && guard.saved) check_unchanged(run);
    return ok;
}

bool guard_numbers(Run *run, bool ok, const double value[], size_t n) {
    for (size_t i = 0; ok && i < n; i++) REQUIRE(run, !isnan(value[i]));
    return ok;
}
