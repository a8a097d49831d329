/* What must hold for each call: a refused call has logged one message, if errors are logged, and has changed nothing,
 * bit for bit; a call that succeeds gives numbers. */
#ifndef FUZZ_GUARD_H
#define FUZZ_GUARD_H

#include "run.h"

/* The first numbers of the bytes of a state (fmu_state.c). */
typedef struct {
    uint64_t mark, format, size, checksum;
    char guid[GUID_SIZE];
} StateHeader;

typedef struct {
    int messages, explained;
    bool saved; /* the state before the call stands in run->before */
} Guard;

/* Before the call. */
Guard guard_begin(Run *run);
/* After the call; returns `ok`. */
bool guard_end(Run *run, Guard guard, bool ok);
/* After a call that gave values: none of them may be NaN. */
bool guard_numbers(Run *run, bool ok, const double value[], size_t n);

/* The bytes of an FMU state; to be freed. */
void *guard_bytes_of(Run *run, void *state, size_t *size);
/* Are both FMU states equal, bit for bit? */
bool guard_same(Run *run, void *state, void *other);

/* ---- the two standards' own functions, unchecked ---- */

bool raw_get_state(Run *run, void **state);
bool raw_free_state(Run *run, void **state);
bool raw_serialize(Run *run, void *state, void *bytes, size_t size);
size_t raw_state_size(Run *run, void *state);

#endif
