/* What the files of FMI 3.0 share: fmi3.c, fmi3_variables.c and fmi3_unsupported.c. */
#ifndef DUALCAM_VERSION3_H
#define DUALCAM_VERSION3_H

#include "fmi3Functions.h"

#include "fmi/instance.h"

static inline fmi3Status status_of(bool good) {
    return good ? fmi3OK : fmi3Error;
}

/* The log of an importer's callback, which may be NULL. */
Log fmi3_log(fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger);

#endif
