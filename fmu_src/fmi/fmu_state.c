#include "fmi/fmu_state.h"

#include <stdlib.h>
#include <string.h>

#include "fmi/snapshot.h"

static bool is_snapshot(const Instance *instance, const char *function, const void *state) {
    return snapshot_is_valid(state) ||
           instance_refuse(instance, "%s: FMU state %s: allowed is one that this FMU has given", function,
                           state == NULL ? "= NULL" : "is not of this FMU");
}

/* The memory that a state is written to: *state, or new memory if *state is NULL. NULL if neither is possible. */
static Snapshot *memory_for_state(const Instance *instance, const char *function, void *const *state) {
    if (!instance_has_pointer(instance, function, state, "FMUstate")) return NULL;
    if (*state != NULL) return is_snapshot(instance, function, *state) ? *state : NULL;
    Snapshot *snapshot = calloc(1, sizeof *snapshot);
    if (snapshot == NULL) instance_refuse(instance, "%s: no memory left", function);
    return snapshot;
}

bool fmu_state_get(const Instance *instance, const char *function, void **state) {
    if (!instance_is_in(instance, function, ~(unsigned)PHASES_INSIDE_STEP)) return false;
    Snapshot *snapshot = memory_for_state(instance, function, state);
    if (snapshot == NULL) return false;
    snapshot_take(snapshot, instance);
    *state = snapshot;
    return true;
}

bool fmu_state_set(Instance *instance, const char *function, const void *state) {
    if (!instance_is_in(instance, function, ~(unsigned)PHASES_INSIDE_STEP) || !is_snapshot(instance, function, state))
        return false;
    Fault fault;
    return snapshot_restore(state, instance, &fault) || instance_refuse(instance, "%s: %s", function, fault.text);
}

bool fmu_state_free(const Instance *instance, const char *function, void **state) {
    if (instance == NULL) return false;
    if (state == NULL || *state == NULL) return true;
    if (!is_snapshot(instance, function, *state)) return false;
    free(*state);
    *state = NULL;
    return true;
}

bool fmu_state_size(const Instance *instance, const char *function, const void *state, size_t *size) {
    if (instance == NULL || !is_snapshot(instance, function, state) ||
        !instance_has_pointer(instance, function, size, "size"))
        return false;
    *size = sizeof(SerializedSnapshot);
    return true;
}

bool fmu_state_serialize(const Instance *instance, const char *function, const void *state, void *bytes, size_t size) {
    if (instance == NULL || !is_snapshot(instance, function, state) ||
        !instance_has_pointer(instance, function, bytes, "serializedState"))
        return false;
    if (size < sizeof(SerializedSnapshot))
        return instance_refuse(instance, "%s: size = %zu: allowed is at least %zu", function, size,
                               sizeof(SerializedSnapshot));
    snapshot_serialize(state, bytes);
    return true;
}

bool fmu_state_deserialize(const Instance *instance, const char *function, const void *bytes, size_t size,
                           void **state) {
    if (instance == NULL || !instance_has_pointer(instance, function, bytes, "serializedState")) return false;
    Fault fault;
    Snapshot snapshot;
    if (!snapshot_deserialize(bytes, size, &snapshot, &fault))
        return instance_refuse(instance, "%s: %s", function, fault.text);
    Snapshot *memory = memory_for_state(instance, function, state);
    if (memory == NULL) return false;
    memcpy(memory, &snapshot, sizeof snapshot);
    *state = memory;
    return true;
}
