/* Everything that a restored run needs, in one piece of memory and as bytes. */
#ifndef DUALCAM_SNAPSHOT_H
#define DUALCAM_SNAPSHOT_H

#include "instance.h"

typedef struct {
    uint64_t magic; /* tells a snapshot from other memory */
    Params params;
    Inputs inputs;
    State state;
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
void snapshot_restore(const Snapshot *snapshot, Instance *instance);

/* False for NULL and for memory that no snapshot_take() filled. */
bool snapshot_is_valid(const Snapshot *snapshot);

/* `bytes` has room for a SealedSnapshot and need not be aligned. */
void snapshot_seal(const Snapshot *snapshot, char *bytes);

/* Returns false and fills `fault` if these are not the bytes of a snapshot of this FMU. */
bool snapshot_open(const char *bytes, size_t size, Snapshot *snapshot, Fault *fault);

#endif
