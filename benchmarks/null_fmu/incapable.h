/* The functions of FMI 2.0 that an FMU without capabilities does not support. Calls that need a capability return
 * fmi2Error; calls that the FMU may ignore succeed without effect. All functions exist, because masters look all of
 * them up.
 */
#ifndef INCAPABLE_H
#define INCAPABLE_H

#include "fmi2Functions.h"

#define SUCCEED(name, ...) fmi2Status name(__VA_ARGS__) { return fmi2OK; }
#define REFUSE(name, ...) fmi2Status name(__VA_ARGS__) { return fmi2Error; }
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
typedef fmi2Component C;
typedef const fmi2ValueReference *References;

SUCCEED(fmi2SetDebugLogging, C c, fmi2Boolean on, size_t n, const fmi2String categories[])
SUCCEED(fmi2SetupExperiment, C c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start,
        fmi2Boolean stop_defined, fmi2Real stop)
SUCCEED(fmi2Terminate, C c)

REFUSE(fmi2GetFMUstate, C c, fmi2FMUstate *state)
REFUSE(fmi2SetFMUstate, C c, fmi2FMUstate state)
REFUSE(fmi2FreeFMUstate, C c, fmi2FMUstate *state)
REFUSE(fmi2SerializedFMUstateSize, C c, fmi2FMUstate state, size_t *size)
REFUSE(fmi2SerializeFMUstate, C c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
REFUSE(fmi2DeSerializeFMUstate, C c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
REFUSE(fmi2GetDirectionalDerivative, C c, References unknown, size_t n_unknown, References known, size_t n_known,
       const fmi2Real dv_known[], fmi2Real dv_unknown[])
REFUSE(fmi2SetRealInputDerivatives, C c, References vr, size_t n, const fmi2Integer order[], const fmi2Real value[])
REFUSE(fmi2GetRealOutputDerivatives, C c, References vr, size_t n, const fmi2Integer order[], fmi2Real value[])
REFUSE(fmi2CancelStep, C c)
REFUSE(fmi2GetStatus, C c, const fmi2StatusKind kind, fmi2Status *value)
REFUSE(fmi2GetRealStatus, C c, const fmi2StatusKind kind, fmi2Real *value)
REFUSE(fmi2GetIntegerStatus, C c, const fmi2StatusKind kind, fmi2Integer *value)
REFUSE(fmi2GetBooleanStatus, C c, const fmi2StatusKind kind, fmi2Boolean *value)
REFUSE(fmi2GetStringStatus, C c, const fmi2StatusKind kind, fmi2String *value)
#pragma GCC diagnostic pop

#endif
