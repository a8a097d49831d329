/* A part (part.h) as an FMU: FMI 2.0 co-simulation with real variables only.
 *
 * Parameters are set before the end of initialization, inputs at any time, finite numbers both. What the XML does
 * not promise (states, derivatives, asynchronous steps) is refused.
 */
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../benchmarks/null_fmu/incapable.h"
#include "part.h"

typedef enum { PARAMETER, INPUT, OUTPUT, LOCAL } Causality;

typedef struct {
    const char *name;
    Causality causality;
    double start;
} Variable;

#define LIST_VARIABLES
#include "part_variables.h"

typedef enum { INSTANTIATED, INITIALIZING, RUNNING } Phase;

typedef struct {
    double value[VARIABLE_COUNT];
    Phase phase;
    fmi2CallbackFunctions callbacks;
    char name[64];
} Instance;

/* The text has names and numbers only: nothing in it that a master would expand. */
static fmi2Status refuse(Instance *self, const char *format, ...) {
    if (self->callbacks.logger == NULL) return fmi2Error;
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    self->callbacks.logger(self->callbacks.componentEnvironment, self->name, fmi2Error, "logStatusError", text);
    return fmi2Error;
}

static void set_start_values(Instance *self) {
    for (size_t i = 0; i < VARIABLE_COUNT; i++) self->value[i] = VARIABLES[i].start;
    self->phase = INSTANTIATED;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)resources, (void)visible, (void)logging;
    if (type != fmi2CoSimulation || guid == NULL || strcmp(guid, MODEL_GUID) != 0) return NULL;
    Instance *self = calloc(1, sizeof *self);
    if (self == NULL) return NULL;
    if (callbacks != NULL) self->callbacks = *callbacks;
    snprintf(self->name, sizeof self->name, "%s", name != NULL ? name : "");
    set_start_values(self);
    return self;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2Reset(fmi2Component c) {
    set_start_values(c);
    return fmi2OK;
}

/* Parameters that make no sense, such as a ratio of 0, show in what is computed from them. */
static fmi2Status check_values(Instance *self) {
    for (size_t i = 0; i < VARIABLE_COUNT; i++) {
        if (!isfinite(self->value[i])) {
            return refuse(self, "%s = %g is not a finite number", VARIABLES[i].name, self->value[i]);
        }
    }
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Instance *self = c;
    if (self->phase != INSTANTIATED) return refuse(self, "it is already initialized");
    self->phase = INITIALIZING;
    part_initialize(self->value);
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Instance *self = c;
    if (self->phase != INITIALIZING) return refuse(self, "it is not in initialization mode");
    part_initialize(self->value); /* parameters may have come late */
    self->phase = RUNNING;
    return check_values(self);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state) {
    (void)no_set_state;
    Instance *self = c;
    if (self->phase != RUNNING) return refuse(self, "a step before the end of initialization");
    if (!(step > 0.0) || !isfinite(step) || !isfinite(time)) {
        return refuse(self, "a step of %g s at %g s", step, time);
    }
    const char *reason = part_step(self->value, time, step);
    return reason == NULL ? check_values(self) : refuse(self, "a step of %g s at %g s: %s", step, time, reason);
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    Instance *self = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= VARIABLE_COUNT) return refuse(self, "no variable has the value reference %u", vr[i]);
        value[i] = self->value[vr[i]];
    }
    return fmi2OK;
}

static bool may_set(const Instance *self, Causality causality) {
    return causality == INPUT || (causality == PARAMETER && self->phase != RUNNING);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    Instance *self = c;
    for (size_t i = 0; i < n; i++) { /* all are looked at before one is set */
        if (vr[i] >= VARIABLE_COUNT) return refuse(self, "no variable has the value reference %u", vr[i]);
        const Variable *variable = &VARIABLES[vr[i]];
        if (!may_set(self, variable->causality)) return refuse(self, "%s cannot be set now", variable->name);
        if (!isfinite(value[i])) return refuse(self, "%s = %g is not a finite number", variable->name, value[i]);
    }
    for (size_t i = 0; i < n; i++) self->value[vr[i]] = value[i];
    return fmi2OK;
}

/* Variables of other types: there are none. */
#define NONE(name, ...) fmi2Status name(__VA_ARGS__) { return n == 0 ? fmi2OK : fmi2Error; }
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
NONE(fmi2GetInteger, C c, References vr, size_t n, fmi2Integer value[])
NONE(fmi2GetBoolean, C c, References vr, size_t n, fmi2Boolean value[])
NONE(fmi2GetString, C c, References vr, size_t n, fmi2String value[])
NONE(fmi2SetInteger, C c, References vr, size_t n, const fmi2Integer value[])
NONE(fmi2SetBoolean, C c, References vr, size_t n, const fmi2Boolean value[])
NONE(fmi2SetString, C c, References vr, size_t n, const fmi2String value[])
#pragma GCC diagnostic pop
