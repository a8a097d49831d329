/* The standard that this FMU implements, FMI 2.0 or FMI 3.0, as the files fmi2.c and fmi3*.c share it.
 *
 * The room fmi/ holds the functions of FMI 2.0 (fmi2.c), of FMI 3.0 (fmi3*.c) and of both (fmi.c). They translate the
 * names and types of the standard. Below them stands what both share: the instance, access to variables, simulation, FMU
 * states. The tables of variables come from variables.def and dependencies.def. No physics stands here: model.h calls
 * forward or inverse dynamics.
 *
 * May include: platform, elementary, numerics, model, geometry, contact, closed_form, collocation, forward, inverse,
 * outputs, sensitivity. */
#ifndef DUALCAM_FMI_H
#define DUALCAM_FMI_H

#include "fmi/instance.h"

#if FMI_VERSION == 2
#include "fmi2Functions.h"

#define FMI(name) fmi2##name
#define FMI_STATE(before, after) fmi2##before##FMUstate##after
typedef fmi2Status Status;
typedef fmi2Boolean Boolean;
typedef fmi2String Text;
typedef fmi2Byte Byte;

#else
#include "fmi3Functions.h"

#define FMI(name) fmi3##name
#define FMI_STATE(before, after) fmi3##before##FMUState##after
typedef fmi3Status Status;
typedef fmi3Boolean Boolean;
typedef fmi3String Text;
typedef fmi3Byte Byte;

/* The log of an importer's callback, which may be NULL. */
Log fmi3_log(fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger);
#endif

static inline Status status_of(bool good) {
    return good ? FMI(OK) : FMI(Error);
}

#endif
