/* A snapshot: everything that a restored FMU state needs, in one struct, and as serialized bytes. */
#ifndef DUALCAM_SNAPSHOT_H
#define DUALCAM_SNAPSHOT_H

#include "fmi/instance.h"

typedef struct {
    uint64_t magic; /* distinguishes a snapshot from other memory */
    Params params;
    FmuInputs inputs;
    FmuState state;
    Run run;
} Snapshot;

/* With a header that shows damaged bytes and bytes of another FMU. */
typedef struct {
    uint64_t magic;
    uint64_t format;
    uint64_t size;     /* of the snapshot */
    uint64_t checksum; /* of the snapshot */
    char guid[64];
    Snapshot snapshot;
} SerializedSnapshot;

void snapshot_take(Snapshot *snapshot, const Instance *instance);

/* False, with the reason in `fault` and the instance as before, if the transmission cannot be built from the parameters. A
 * snapshot holds the path of a table, not the table. So a file that has changed since gives another geometry, and a file
 * that was removed gives none, unless the instance has read the file already. */
bool snapshot_restore(const Snapshot *snapshot, Instance *instance, Fault *fault);

/* False for NULL and for memory that snapshot_take() did not fill. */
bool snapshot_is_valid(const Snapshot *snapshot);

/* `bytes` has room for a SerializedSnapshot; any alignment will do. */
void snapshot_serialize(const Snapshot *snapshot, char *bytes);

/* False, with the reason in `fault`, if the bytes are not those of a snapshot of this FMU. */
bool snapshot_deserialize(const char *bytes, size_t size, Snapshot *snapshot, Fault *fault);

#endif
