/* Samples of a groove from a CSV file: header `psi_rad,z_m`, then two numbers per line. */
#ifndef DUALCAM_GROOVE_CSV_H
#define DUALCAM_GROOVE_CSV_H

#include <stdbool.h>
#include <stddef.h>

#include "model/fault.h"
#include "numerics/tolerances.h"

typedef struct {
    double psi; /* rad */
    double z;   /* m */
} Sample;

/* psi strictly increases and includes 0; z does not decrease. */
typedef struct {
    Sample *sample; /* owned */
    size_t count;
} Samples;

/* Reads the file `path`, which is absolute or relative to the directory `resources` (NULL: there is none).
 * `variable` is the name of the parameter that holds the path, for messages. On failure returns false with the
 * reason in `fault`; `samples` is then empty. */
bool samples_read(Samples *samples, const char *path, const char *resources, const char *variable, Fault *fault);

/* Safe on zeroed Samples, and twice. */
void samples_free(Samples *samples);

#endif
