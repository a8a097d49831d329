#include "fmi/fmu_state.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "numerics/tolerances.h"
#include "platform/arithmetic.h"
#include "platform/attributes.h"

/* Everything that a restored FMU state needs. */
typedef struct {
    uint64_t magic; /* distinguishes a snapshot from other memory */
    Params params;
    ModelInputs inputs;
    ModelState state;
    Run run;
} Snapshot;

/* With a header that shows damaged bytes and bytes of another FMU. */
typedef struct {
    uint64_t magic;
    uint64_t format;
    uint64_t size;     /* of the snapshot */
    uint64_t checksum; /* of the snapshot */
    Guid guid;
    Snapshot snapshot;
} SerializedSnapshot;

/* ---- snapshots ---- */

static const uint64_t SNAPSHOT_MAGIC = UINT64_C(0x74657073736d6163); /* also tells the byte order */
static const uint64_t SERIALIZED_MAGIC = UINT64_C(0x6d61636c6175642e);
enum { FORMAT = 5 }; /* to be raised when the meaning of the bytes changes and the GUID does not */

/* Equal states must have equal bytes, so the bytes that belong to no member are cleared. A new member does not compile
 * before its padding is dealt with. */
enum { PARAMS_END = offsetof(Params, friction_table) + sizeof(((Params *)NULL)->friction_table) };
enum { LAW_END = offsetof(FrictionParams, stribeck_exponent) + sizeof(int) };
_Static_assert(LAW_END == 5 * sizeof(double) + sizeof(int), "padding in FrictionParams");
_Static_assert(sizeof(FrictionParams) - LAW_END < sizeof(double) + sizeof(FrictionTable *),
               "a member of FrictionParams besides the table, which no saved state holds");
_Static_assert(sizeof(CamParams) == 8 * sizeof(double) + sizeof(FrictionParams) + 2 * sizeof(int),
               "padding in CamParams");
_Static_assert(PARAMS_END == 2 * sizeof(CamParams) + sizeof(SpringParams) + sizeof(DamperParams) +
                                 sizeof(InertiaParams) + sizeof(ShaftParams) + sizeof(StopParams) +
                                 sizeof(InitialParams) + sizeof(double) + sizeof(int) + sizeof(bool) +
                                 (size_t)4 * TABLE_PATH_SIZE,
               "padding in Params");
_Static_assert(sizeof(Ledger) == 10 * sizeof(Sum) + sizeof(double) + sizeof(Peaks), "padding in Ledger");
_Static_assert(sizeof(Run) == 2 * sizeof(double) + sizeof(Phase) + 2 * sizeof(uint16_t), "padding in Run");
_Static_assert(sizeof(Snapshot) ==
                   sizeof(uint64_t) + sizeof(Params) + sizeof(ModelInputs) + sizeof(ModelState) + sizeof(Run),
               "padding in Snapshot");

static void clear_padding(Snapshot *snapshot) {
    memset((char *)&snapshot->params + PARAMS_END, 0, sizeof(Params) - PARAMS_END);
    for (int i = 0; i < 2; i++) {
        FrictionParams *law = &snapshot->params.cam[i].law;
        memset((char *)law + LAW_END, 0, sizeof *law - LAW_END); /* the table's address too */
    }
}

/* Before the run has begun the state follows from parameters and inputs, whether it has been computed or not. */
NOINLINE static void snapshot_take(Snapshot *snapshot, const Instance *instance) {
    const FmuModel *model = &instance->values.model;
    snapshot->magic = SNAPSHOT_MAGIC;
    snapshot->params = model->params;
    snapshot->inputs = model->inputs;
    if (instance_has_begun(instance)) snapshot->state = model->state;
    else memset(&snapshot->state, 0, sizeof snapshot->state); /* follows from params and inputs when a value is read */
    snapshot->run = instance->run;
    clear_padding(snapshot);
}

/* Copies a path only if one of both paths is not empty: a path is zeros from its end on. */
static void restore_path(const char path[TABLE_PATH_SIZE], char to[TABLE_PATH_SIZE]) {
    if (path[0] != '\0' || to[0] != '\0') memcpy(to, path, TABLE_PATH_SIZE);
}

/* The friction tables stay those of the instance until model_rebuild() has read those of the paths. */
static void restore_params(const Params *params, Params *to) {
    const FrictionTable *const table[2] = {to->cam[0].law.table, to->cam[1].law.table};
    memcpy(to, params, offsetof(Params, table));
    for (int i = 0; i < 2; i++) {
        to->cam[i].law.table = table[i];
        restore_path(params->table[i], to->table[i]);
        restore_path(params->friction_table[i], to->friction_table[i]);
    }
}

NOINLINE static void restore_members(const Snapshot *snapshot, Instance *instance) {
    FmuModel *model = &instance->values.model;
    restore_params(&snapshot->params, &model->params);
    model->inputs = snapshot->inputs;
    model->state = snapshot->state;
    instance->run = snapshot->run;
    model->continuous = instance_has_begun(instance) && instance->run.interface_type == INTERFACE_MODEL_EXCHANGE;
}

static bool restore_and_build(const Snapshot *snapshot, Instance *instance, Fault *fault) {
    Snapshot before;
    snapshot_take(&before, instance);
    restore_members(snapshot, instance);
    const HostArithmetic host = arithmetic_begin();
    const bool good = model_rebuild(&instance->values.model, fault);
    arithmetic_end(host);
    if (good) return true;
    restore_members(&before, instance);
    instance_invalidate(instance);
    return false;
}

/* False, with the reason in `fault` and the instance as before, if the transmission cannot be built from the
 * parameters. A snapshot holds the path of a table, not the table. So a file that has changed since gives another
 * geometry, and a file that was removed gives none, unless the instance has read the file already.
 *
 * A state of another interface type is refused, since this instance does not have all of its phases. Before the run has
 * begun nothing is built, since the parameters may not be possible yet. */
static bool snapshot_restore(const Snapshot *snapshot, Instance *instance, Fault *fault) {
    if (snapshot->run.interface_type != instance->run.interface_type) {
        snprintf(fault->text, sizeof fault->text, "FMU state of %s: allowed is an FMU state of %s, as this instance",
                 interface_name((InterfaceType)snapshot->run.interface_type),
                 interface_name((InterfaceType)instance->run.interface_type));
        return false;
    }
    if (snapshot->run.phase & PHASES_BEFORE_START) restore_members(snapshot, instance);
    else if (!restore_and_build(snapshot, instance, fault)) return false;
    instance_invalidate(instance);
    return true;
}

/* False for NULL and for memory that snapshot_take() did not fill. */
static bool snapshot_is_valid(const Snapshot *snapshot) {
    return snapshot != NULL && snapshot->magic == SNAPSHOT_MAGIC;
}

/* ---- serialized bytes ---- */

/* FNV-1a, 64 bits (G. Fowler, L. Noll, P. Vo): each round is invertible, so any single changed byte changes the sum. */
static uint64_t checksum(const void *bytes, size_t size) {
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < size; i++) hash = (hash ^ byte[i]) * UINT64_C(0x100000001b3);
    return hash;
}

/* Is the value of a parameter or input one that a master may set? Its bytes need not be aligned to anything. */
static bool is_allowed(const Snapshot *snapshot, const Variable *variable) {
    const char *at = (const char *)&snapshot->params + variable->offset;
    double real;
    int integer;
    switch (variable->kind) {
        case KIND_REAL: memcpy(&real, at, sizeof real); return variable_allows(variable, real);
        case KIND_TEXT: return memchr(at, '\0', TABLE_PATH_SIZE) != NULL;
        case KIND_BOOLEAN: return *(const unsigned char *)at <= 1;
        default: memcpy(&integer, at, sizeof integer); return variable_allows(variable, integer);
    }
}

_Static_assert(offsetof(Values, model.params) == 0, "Variable.offset counts from the parameters");
_Static_assert(offsetof(Snapshot, inputs) - offsetof(Snapshot, params) == offsetof(Values, model.inputs),
               "one offset for both");

static bool are_parameters_allowed(const Snapshot *snapshot) {
    const double tolerance = snapshot->params.tolerance;
    if (!(tolerance >= TOLERANCE_MIN && tolerance <= TOLERANCE_MAX)) return false;
    for (unsigned i = 0; i < START_END; i++)
        if ((VARIABLES[i].group & (GROUP_PARAMS | GROUP_INPUTS)) != 0 && !is_allowed(snapshot, &VARIABLES[i]))
            return false;
    return true;
}

/* An instance of this interface type has all these phases outside of a step. */
static bool is_run_possible(const Run *run) {
    static const unsigned phases[] = {
        [INTERFACE_MODEL_EXCHANGE] = PHASES_BEFORE_START | PHASE_EVENT | PHASE_CONTINUOUS | PHASE_TERMINATED,
        [INTERFACE_CO_SIMULATION] = PHASES_BEFORE_START | PHASE_STEP | PHASE_TERMINATED,
        [INTERFACE_HYBRID_CO_SIMULATION] = PHASES_BEFORE_START | PHASE_EVENT | PHASE_STEP | PHASE_TERMINATED};
    const unsigned phase = run->phase;
    return run->interface_type <= INTERFACE_HYBRID_CO_SIMULATION && (phase & phases[run->interface_type]) != 0 &&
           (phase & (phase - 1)) == 0 && isfinite(run->time) && isfinite(run->completed_until);
}

/* A checksum shows damage, but anybody can compute it. Values that index tables or choose code must be possible, else a
 * forged state would lead the program astray. The numbers of the state are not compared with one another. */
static bool is_snapshot_possible(const Snapshot *snapshot) {
    return are_parameters_allowed(snapshot) && is_run_possible(&snapshot->run) &&
           ((snapshot->run.phase & PHASES_BEFORE_START) != 0 || model_state_is_possible(&snapshot->state));
}

static SerializedSnapshot serialized_of(const Snapshot *snapshot) {
    SerializedSnapshot serialized = {
        .magic = SERIALIZED_MAGIC,
        .format = FORMAT,
        .size = sizeof(Snapshot),
        .checksum = checksum(snapshot, sizeof *snapshot),
        .guid = model_guid(),
    };
    /* an assignment need not copy the cleared padding */
    memcpy(&serialized.snapshot, snapshot, sizeof *snapshot);
    return serialized;
}

/* `bytes` has room for a SerializedSnapshot; any alignment will do. */
static void snapshot_serialize(const Snapshot *snapshot, char *bytes) {
    const SerializedSnapshot serialized = serialized_of(snapshot);
    memcpy(bytes, &serialized, sizeof serialized);
}

/* False, with the reason in `fault`, if the bytes are not those of a snapshot of this FMU. */
static bool snapshot_deserialize(const char *bytes, size_t size, Snapshot *snapshot, Fault *fault) {
    if (size != sizeof(SerializedSnapshot)) {
        snprintf(fault->text, sizeof fault->text, "serialized state of %zu bytes: allowed are only %zu", size,
                 sizeof(SerializedSnapshot));
        return false;
    }
    SerializedSnapshot serialized;
    memcpy(&serialized, bytes, sizeof serialized);
    const SerializedSnapshot expected = serialized_of(&serialized.snapshot);
    char other_guid[128];
    snprintf(other_guid, sizeof other_guid, "is of an FMU with another GUID than %s", expected.guid.text);
    const char *wrong = NULL;
    if (serialized.magic != expected.magic) wrong = "does not begin like a state of this FMU";
    else if (serialized.format != expected.format || serialized.size != expected.size)
        wrong = "is of another version of this FMU";
    else if (memcmp(&serialized.guid, &expected.guid, sizeof serialized.guid) != 0) wrong = other_guid;
    else if (serialized.checksum != expected.checksum || !snapshot_is_valid(&serialized.snapshot))
        wrong = "is damaged: its checksum differs";
    else if (!is_snapshot_possible(&serialized.snapshot)) wrong = "holds values that no state of this FMU has";
    if (wrong != NULL) {
        snprintf(fault->text, sizeof fault->text,
                 "serialized state %s: allowed are only unchanged bytes that it has serialized", wrong);
        return false;
    }
    memcpy(snapshot, &serialized.snapshot, sizeof *snapshot);
    return true;
}

/* ---- behind the pointers of masters ---- */

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

/* Inside a step FMI 3.0 allows no function of FMU states. */
static bool is_between_steps(const Instance *instance, const char *function) {
    return instance_is_in(instance, function, ~(unsigned)PHASES_INSIDE_STEP);
}

bool fmu_state_get(const Instance *instance, const char *function, void **state) {
    if (!is_between_steps(instance, function)) return false;
    Snapshot *snapshot = memory_for_state(instance, function, state);
    if (snapshot == NULL) return false;
    snapshot_take(snapshot, instance);
    *state = snapshot;
    return true;
}

bool fmu_state_set(Instance *instance, const char *function, const void *state) {
    if (!is_between_steps(instance, function) || !is_snapshot(instance, function, state)) return false;
    Fault fault;
    return snapshot_restore(state, instance, &fault) || instance_refuse(instance, "%s: %s", function, fault.text);
}

bool fmu_state_free(const Instance *instance, const char *function, void **state) {
    if (!is_between_steps(instance, function)) return false;
    if (state == NULL || *state == NULL) return true;
    if (!is_snapshot(instance, function, *state)) return false;
    free(*state);
    *state = NULL;
    return true;
}

bool fmu_state_size(const Instance *instance, const char *function, const void *state, size_t *size) {
    if (!is_between_steps(instance, function) || !is_snapshot(instance, function, state) ||
        !instance_has_pointer(instance, function, size, "size"))
        return false;
    *size = sizeof(SerializedSnapshot);
    return true;
}

bool fmu_state_serialize(const Instance *instance, const char *function, const void *state, void *bytes, size_t size) {
    if (!is_between_steps(instance, function) || !is_snapshot(instance, function, state) ||
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
    if (!is_between_steps(instance, function) || !instance_has_pointer(instance, function, bytes, "serializedState"))
        return false;
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
