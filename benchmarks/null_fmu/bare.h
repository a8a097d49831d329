/* FMI 2.0 around a model that is written by hand in one file, as small as it can be: Set stores, Get returns what
 * was stored. It checks nothing but the bounds of its array, keeps no state machine and logs nothing. The file
 * that includes it writes fmi2ExitInitializationMode and fmi2DoStep.
 */
#ifndef BARE_H
#define BARE_H

#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#ifndef VALUE_COUNT
#error "VALUE_COUNT (highest value reference + 1) is given by build_fmu.py"
#endif

typedef struct {
    fmi2Real real[VALUE_COUNT];
    fmi2Integer integer[VALUE_COUNT];
    fmi2Boolean boolean[VALUE_COUNT];
    fmi2Real kept[2]; /* by the model, from initialization on */
} Values;

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible,
                              fmi2Boolean logging) {
    (void)name, (void)resources, (void)callbacks, (void)visible, (void)logging;
    if (type != fmi2CoSimulation || strcmp(guid, MODEL_GUID) != 0) return NULL;
    return calloc(1, sizeof(Values));
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

#define ACCESS(Type, field)                                                                             \
    fmi2Status fmi2Get##Type(fmi2Component c, const fmi2ValueReference vr[], size_t n,                  \
                             fmi2##Type value[]) {                                                      \
        const Values *values = c;                                                                       \
        for (size_t i = 0; i < n; i++) {                                                                \
            if (vr[i] >= VALUE_COUNT) return fmi2Error;                                                 \
            value[i] = values->field[vr[i]];                                                            \
        }                                                                                               \
        return fmi2OK;                                                                                  \
    }                                                                                                   \
    fmi2Status fmi2Set##Type(fmi2Component c, const fmi2ValueReference vr[], size_t n,                  \
                             const fmi2##Type value[]) {                                                \
        Values *values = c;                                                                             \
        for (size_t i = 0; i < n; i++) {                                                                \
            if (vr[i] >= VALUE_COUNT) return fmi2Error;                                                 \
            values->field[vr[i]] = value[i];                                                            \
        }                                                                                               \
        return fmi2OK;                                                                                  \
    }
ACCESS(Real, real)
ACCESS(Integer, integer)
ACCESS(Boolean, boolean)

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    (void)c, (void)vr;
    for (size_t i = 0; i < n; i++) value[i] = "";
    return fmi2OK;
}

/* The rest: success without effect, or fmi2Error where the XML promises no such capability. */
#define SUCCEED(name, ...) fmi2Status name(__VA_ARGS__) { return fmi2OK; }
#define REFUSE(name, ...) fmi2Status name(__VA_ARGS__) { return fmi2Error; }
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
typedef fmi2Component C;
typedef const fmi2ValueReference *References;

SUCCEED(fmi2SetDebugLogging, C c, fmi2Boolean on, size_t n, const fmi2String categories[])
SUCCEED(fmi2SetupExperiment, C c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start,
        fmi2Boolean stop_defined, fmi2Real stop)
SUCCEED(fmi2EnterInitializationMode, C c)
SUCCEED(fmi2Terminate, C c)
SUCCEED(fmi2Reset, C c)
SUCCEED(fmi2SetString, C c, References vr, size_t n, const fmi2String value[])

REFUSE(fmi2GetFMUstate, C c, fmi2FMUstate *state)
REFUSE(fmi2SetFMUstate, C c, fmi2FMUstate state)
REFUSE(fmi2FreeFMUstate, C c, fmi2FMUstate *state)
REFUSE(fmi2SerializedFMUstateSize, C c, fmi2FMUstate state, size_t *size)
REFUSE(fmi2SerializeFMUstate, C c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
REFUSE(fmi2DeSerializeFMUstate, C c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
REFUSE(fmi2GetDirectionalDerivative, C c, References unknown, size_t n_unknown, References known,
       size_t n_known, const fmi2Real dv_known[], fmi2Real dv_unknown[])
REFUSE(fmi2SetRealInputDerivatives, C c, References vr, size_t n, const fmi2Integer order[],
       const fmi2Real value[])
REFUSE(fmi2GetRealOutputDerivatives, C c, References vr, size_t n, const fmi2Integer order[],
       fmi2Real value[])
REFUSE(fmi2CancelStep, C c)
REFUSE(fmi2GetStatus, C c, const fmi2StatusKind kind, fmi2Status *value)
REFUSE(fmi2GetRealStatus, C c, const fmi2StatusKind kind, fmi2Real *value)
REFUSE(fmi2GetIntegerStatus, C c, const fmi2StatusKind kind, fmi2Integer *value)
REFUSE(fmi2GetBooleanStatus, C c, const fmi2StatusKind kind, fmi2Boolean *value)
REFUSE(fmi2GetStringStatus, C c, const fmi2StatusKind kind, fmi2String *value)
#pragma GCC diagnostic pop

#endif
