/* The functions of FMI 2.0 that hash.c calls, from the binary that the environment variable FMU_BINARY names. */
#include <stdio.h>
#include <stdlib.h>

#include "../library.h"
#include "fmi2Functions.h"

static void *function(const char *name) {
    static void *library;
    const char *path = getenv("FMU_BINARY");
    if (library == NULL && path != NULL) library = library_open(path);
    void *found = library == NULL ? NULL : library_find(library, name);
    if (found != NULL) return found;
    fprintf(stderr, "hash: no %s in the binary FMU_BINARY = %s\n", name, path == NULL ? "(not set)" : path);
    exit(1);
}

#define CALL(name, ...)                                                                                        \
    LIBRARY_FUNCTION(name##TYPE, in_binary, function(#name));                                                  \
    return in_binary.call(__VA_ARGS__)

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    CALL(fmi2Instantiate, name, type, guid, resources, callbacks, visible, logging);
}

void fmi2FreeInstance(fmi2Component c) {
    LIBRARY_FUNCTION(fmi2FreeInstanceTYPE, in_binary, function("fmi2FreeInstance"));
    in_binary.call(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
    CALL(fmi2SetupExperiment, c, has_tolerance, tolerance, start, has_stop, stop);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { CALL(fmi2EnterInitializationMode, c); }

fmi2Status fmi2ExitInitializationMode(fmi2Component c) { CALL(fmi2ExitInitializationMode, c); }

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference *vr, size_t n, const fmi2Real *value) {
    CALL(fmi2SetReal, c, vr, n, value);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference *vr, size_t n, const fmi2Integer *value) {
    CALL(fmi2SetInteger, c, vr, n, value);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference *vr, size_t n, const fmi2Boolean *value) {
    CALL(fmi2SetBoolean, c, vr, n, value);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference *vr, size_t n, const fmi2String *value) {
    CALL(fmi2SetString, c, vr, n, value);
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference *vr, size_t n, fmi2Real *value) {
    CALL(fmi2GetReal, c, vr, n, value);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference *vr, size_t n, fmi2Integer *value) {
    CALL(fmi2GetInteger, c, vr, n, value);
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference *vr, size_t n,
                                       const fmi2Integer *order, const fmi2Real *value) {
    CALL(fmi2SetRealInputDerivatives, c, vr, n, order, value);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference *unknown, size_t unknowns,
                                        const fmi2ValueReference *known, size_t knowns, const fmi2Real *seed,
                                        fmi2Real *change) {
    CALL(fmi2GetDirectionalDerivative, c, unknown, unknowns, known, knowns, seed, change);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state) {
    CALL(fmi2DoStep, c, time, step, no_set_state);
}
