/* Everything that a restored run needs, in one piece of memory and as bytes. */
#ifndef DUALCAM_SNAPSHOT_H
#define DUALCAM_SNAPSHOT_H

#include "fmi/instance.h"

typedef struct {
    uint64_t magic; /* tells a snapshot from other memory */
    Params params;
    MachineInputs inputs;
    MachineState state;
    Run run;
} Snapshot;

/* Sealed by a header that tells damaged bytes and those of another FMU from its own. */
typedef struct {
    uint64_t magic;
    uint64_t format;
    uint64_t size;     /* of the snapshot */
    uint64_t checksum; /* of the snapshot */
    char guid[64];
    Snapshot snapshot;
} SealedSnapshot;

void snapshot_take(Snapshot *snapshot, const Instance *instance);

/* Returns false, with the reason in `fault` and the instance as before, if what the parameters imply cannot be
 * built. A snapshot holds the path of a table, not its contents: a file that has changed since gives another
 * geometry, and one that is gone none, unless the instance has read it already. */
bool snapshot_restore(const Snapshot *snapshot, Instance *instance, Fault *fault);

/* False for NULL and for memory that no snapshot_take() filled. */
bool snapshot_is_valid(const Snapshot *snapshot);

/* `bytes` has room for a SealedSnapshot and need not be aligned. */
void snapshot_seal(const Snapshot *snapshot, char *bytes);

/* Returns false and fills `fault` if these are not the bytes of a snapshot of this FMU. */
bool snapshot_open(const char *bytes, size_t size, Snapshot *snapshot, Fault *fault);

#endif
