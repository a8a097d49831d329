/* The smallest FMI 2.0 around a model that is written by hand in one file: Set stores a value, Get returns the stored
 * value. Only the bounds of the array are checked. There is no state machine and no logging. The including file
 * defines fmi2ExitInitializationMode and fmi2DoStep.
 */
#ifndef BARE_H
#define BARE_H

#include <stdlib.h>
#include <string.h>

#include "incapable.h"

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

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
SUCCEED(fmi2EnterInitializationMode, C c)
SUCCEED(fmi2Reset, C c)
SUCCEED(fmi2SetString, C c, References vr, size_t n, const fmi2String value[])
#pragma GCC diagnostic pop

#endif
