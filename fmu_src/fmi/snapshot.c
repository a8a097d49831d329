#include "fmi/snapshot.h"

#include <stdio.h>
#include <string.h>

#ifndef MODEL_GUID
#error "MODEL_GUID, the GUID in modelDescription.xml, is given by the build"
#endif

static const uint64_t SNAPSHOT_MAGIC = UINT64_C(0x74657073736d6163); /* also tells the byte order */
static const uint64_t SEAL_MAGIC = UINT64_C(0x6d61636c6175642e);
enum { FORMAT = 3 }; /* to be raised when the meaning of the bytes changes but the GUID does not */

/* Equal states must have equal bytes, so the few bytes that belong to no member are cleared. A new member
 * fails here (or at model_clear_padding()) until its padding is looked at. */
enum { PARAMS_END = offsetof(Params, table) + sizeof(((Params *)NULL)->table) };
_Static_assert(sizeof(CamParams) == 5 * sizeof(double) + 2 * sizeof(int), "padding in CamParams");
_Static_assert(PARAMS_END == 2 * sizeof(CamParams) + sizeof(SpringParams) + sizeof(DamperParams) +
                                 sizeof(InertiaParams) + sizeof(ShaftParams) + sizeof(StopParams) +
                                 sizeof(InitialParams) + sizeof(double) + sizeof(int) + sizeof(bool) +
                                 2 * TABLE_PATH_SIZE,
               "padding in Params");
_Static_assert(sizeof(Ledger) == 8 * sizeof(Sum) + sizeof(double) + sizeof(Peaks), "padding in Ledger");
_Static_assert(sizeof(Run) == 2 * sizeof(double) + sizeof(Phase) + 2 * sizeof(uint16_t), "padding in Run");
_Static_assert(sizeof(Snapshot) ==
                   sizeof(uint64_t) + sizeof(Params) + sizeof(MachineInputs) + sizeof(MachineState) + sizeof(Run),
               "padding in Snapshot");

static void clear_padding(Snapshot *snapshot) {
    memset((char *)&snapshot->params + PARAMS_END, 0, sizeof(Params) - PARAMS_END);
    model_clear_padding(&snapshot->state);
}

void snapshot_take(Snapshot *snapshot, const Instance *instance) {
    const Machine *machine = &instance->values.machine;
    snapshot->magic = SNAPSHOT_MAGIC;
    snapshot->params = machine->params;
    snapshot->inputs = machine->inputs;
    snapshot->state = machine->state;
    snapshot->run = instance->run;
    clear_padding(snapshot);
}

/* A table's path is zeros from its end on, so that no path need not be copied over no path. */
static void put_params(const Params *params, Params *to) {
    memcpy(to, params, offsetof(Params, table));
    for (int i = 0; i < 2; i++)
        if (params->table[i][0] != '\0' || to->table[i][0] != '\0')
            memcpy(to->table[i], params->table[i], sizeof to->table[i]);
}

static void put(const Snapshot *snapshot, Instance *instance) {
    Machine *machine = &instance->values.machine;
    put_params(&snapshot->params, &machine->params);
    machine->inputs = snapshot->inputs;
    machine->state = snapshot->state;
    instance->run = snapshot->run;
    machine->continuous = instance_has_begun(instance) && instance->run.use == MODEL_EXCHANGE;
}

static bool put_and_build(const Snapshot *snapshot, Instance *instance, Fault *fault) {
    Snapshot before;
    snapshot_take(&before, instance);
    put(snapshot, instance);
    if (model_rebuild(&instance->values.machine, fault)) return true;
    put(&before, instance);
    return false;
}

/* A state of another use is refused: its phase would be none of this instance's. Before the run has begun there is
 * nothing to build yet: the parameters may not even be possible. */
bool snapshot_restore(const Snapshot *snapshot, Instance *instance, Fault *fault) {
    if (snapshot->run.use != instance->run.use) {
        snprintf(fault->text, sizeof fault->text,
                 "FMU state of %s: allowed is one of the way in which this instance is used",
                 use_name((Use)snapshot->run.use));
        return false;
    }
    if (snapshot->run.phase & PHASES_BEFORE_START) put(snapshot, instance);
    else if (!put_and_build(snapshot, instance, fault)) return false;
    instance_changed(instance);
    return true;
}

bool snapshot_is_valid(const Snapshot *snapshot) {
    return snapshot != NULL && snapshot->magic == SNAPSHOT_MAGIC;
}

/* ---- bytes ---- */

/* FNV-1a, 64 bits: any single changed byte changes it, since each round is invertible. */
static uint64_t checksum(const void *bytes, size_t size) {
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < size; i++) hash = (hash ^ byte[i]) * UINT64_C(0x100000001b3);
    return hash;
}

static SealedSnapshot seal(const Snapshot *snapshot) {
    SealedSnapshot sealed = {
        .magic = SEAL_MAGIC,
        .format = FORMAT,
        .size = sizeof(Snapshot),
        .checksum = checksum(snapshot, sizeof *snapshot),
        .guid = MODEL_GUID,
    };
    /* not by assignment, which need not copy the cleared padding */
    memcpy(&sealed.snapshot, snapshot, sizeof *snapshot);
    return sealed;
}

void snapshot_seal(const Snapshot *snapshot, char *bytes) {
    const SealedSnapshot sealed = seal(snapshot);
    memcpy(bytes, &sealed, sizeof sealed);
}

bool snapshot_open(const char *bytes, size_t size, Snapshot *snapshot, Fault *fault) {
    if (size != sizeof(SealedSnapshot)) {
        snprintf(fault->text, sizeof fault->text, "serialized state of %zu bytes: allowed are only %zu", size,
                 sizeof(SealedSnapshot));
        return false;
    }
    SealedSnapshot sealed;
    memcpy(&sealed, bytes, sizeof sealed);
    const SealedSnapshot expected = seal(&sealed.snapshot);
    const char *wrong = NULL;
    if (sealed.magic != expected.magic) wrong = "does not begin like a state of this FMU";
    else if (sealed.format != expected.format || sealed.size != expected.size)
        wrong = "is of another version of this FMU";
    else if (memcmp(sealed.guid, expected.guid, sizeof sealed.guid) != 0)
        wrong = "is of an FMU with another GUID than " MODEL_GUID;
    else if (sealed.checksum != expected.checksum || !snapshot_is_valid(&sealed.snapshot))
        wrong = "is damaged: its checksum differs";
    if (wrong != NULL) {
        snprintf(fault->text, sizeof fault->text,
                 "serialized state %s: allowed are only unchanged bytes that it has serialized", wrong);
        return false;
    }
    memcpy(snapshot, &sealed.snapshot, sizeof *snapshot);
    return true;
}
