#define _GNU_SOURCE
#include "calls.h"

#include <dlfcn.h>
#include <string.h>

#include "../lifecycle/support.h"
#include "fmi3Functions.h"

#define FUNCTIONS_OF_FMI2(X)                                                                                           \
    X(2, Instantiate)                                                                                                  \
    X(2, FreeInstance)                                                                                                 \
    X(2, SetupExperiment)                                                                                              \
    X(2, EnterInitializationMode)                                                                                      \
    X(2, ExitInitializationMode)                                                                                       \
    X(2, Terminate)                                                                                                    \
    X(2, Reset)                                                                                                        \
    X(2, GetReal)                                                                                                      \
    X(2, GetInteger)                                                                                                   \
    X(2, SetReal)                                                                                                      \
    X(2, SetInteger)                                                                                                   \
    X(2, SetBoolean)                                                                                                   \
    X(2, SetString)                                                                                                    \
    X(2, GetFMUstate)                                                                                                  \
    X(2, SetFMUstate)                                                                                                  \
    X(2, FreeFMUstate)                                                                                                 \
    X(2, SerializedFMUstateSize)                                                                                       \
    X(2, SerializeFMUstate)                                                                                            \
    X(2, DeSerializeFMUstate)                                                                                          \
    X(2, GetDirectionalDerivative)                                                                                     \
    X(2, SetRealInputDerivatives)                                                                                      \
    X(2, GetRealOutputDerivatives)                                                                                     \
    X(2, DoStep)                                                                                                       \
    X(2, EnterEventMode)                                                                                               \
    X(2, NewDiscreteStates)                                                                                            \
    X(2, EnterContinuousTimeMode)                                                                                      \
    X(2, CompletedIntegratorStep)                                                                                      \
    X(2, SetTime)                                                                                                      \
    X(2, SetContinuousStates)                                                                                          \
    X(2, GetContinuousStates)                                                                                          \
    X(2, GetDerivatives)                                                                                               \
    X(2, GetEventIndicators)

#define FUNCTIONS_OF_FMI3(X)                                                                                           \
    X(3, InstantiateCoSimulation)                                                                                      \
    X(3, InstantiateModelExchange)                                                                                     \
    X(3, FreeInstance)                                                                                                 \
    X(3, EnterInitializationMode)                                                                                      \
    X(3, ExitInitializationMode)                                                                                       \
    X(3, Terminate)                                                                                                    \
    X(3, Reset)                                                                                                        \
    X(3, GetFloat64)                                                                                                   \
    X(3, GetInt32)                                                                                                     \
    X(3, SetFloat64)                                                                                                   \
    X(3, SetInt32)                                                                                                     \
    X(3, SetBoolean)                                                                                                   \
    X(3, SetString)                                                                                                    \
    X(3, GetFMUState)                                                                                                  \
    X(3, SetFMUState)                                                                                                  \
    X(3, FreeFMUState)                                                                                                 \
    X(3, SerializedFMUStateSize)                                                                                       \
    X(3, SerializeFMUState)                                                                                            \
    X(3, DeserializeFMUState)                                                                                          \
    X(3, GetDirectionalDerivative)                                                                                     \
    X(3, GetOutputDerivatives)                                                                                         \
    X(3, DoStep)                                                                                                       \
    X(3, EnterEventMode)                                                                                               \
    X(3, UpdateDiscreteStates)                                                                                         \
    X(3, EnterContinuousTimeMode)                                                                                      \
    X(3, CompletedIntegratorStep)                                                                                      \
    X(3, SetTime)                                                                                                      \
    X(3, SetContinuousStates)                                                                                          \
    X(3, GetContinuousStates)                                                                                          \
    X(3, GetContinuousStateDerivatives)                                                                                \
    X(3, GetEventIndicators)

#define MEMBER(version, name) fmi##version##name##TYPE *name;
static struct {
    FUNCTIONS_OF_FMI2(MEMBER)
} two;
static struct {
    FUNCTIONS_OF_FMI3(MEMBER)
} three;

static bool version3;

void (*before_call)(void), (*after_call)(void), (*intermediate_update)(void);

/* ---- the binary ---- */

static void end_without(const char *what) {
    fprintf(stderr, "faults: no %s: %s\n", what, dlerror());
    exit(1);
}

/* Copies the object pointer of dlsym() into a function pointer, as POSIX allows. */
static void look_up(void *library, const char *name, void *function) {
    void *const found = dlsym(library, name);
    if (found == NULL) end_without(name);
    memcpy(function, &found, sizeof found);
}

#define LOOK_UP2(version, name) look_up(library, "fmi2" #name, &two.name);
#define LOOK_UP3(version, name) look_up(library, "fmi3" #name, &three.name);

void open_fmu(const char *path) {
    void *const library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) end_without(path);
    version3 = dlsym(library, "fmi3GetVersion") != NULL;
    if (version3) {
        FUNCTIONS_OF_FMI3(LOOK_UP3)
    } else {
        FUNCTIONS_OF_FMI2(LOOK_UP2)
    }
}

bool is_fmi3(void) {
    return version3;
}

/* ---- calls ---- */

static void begin(void) {
    if (before_call != NULL) before_call();
}

static void end(void) {
    if (after_call != NULL) after_call();
}

static fmi2Status ended2(fmi2Status status) {
    end();
    return status;
}

/* The numbers of the statuses are the same in both versions. */
static fmi2Status ended3(fmi3Status status) {
    end();
    return (fmi2Status)status;
}

/* The environment of an instance of FMI 3.0 is the struct of callbacks of FMI 2.0. */
static void log_of_fmi3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                        fmi3String message) {
    const fmi2CallbackFunctions *functions = environment;
    functions->logger(functions->componentEnvironment, "", (fmi2Status)status, category, message);
}

static fmi2Component instantiate3(fmi2String name, fmi2Type type, fmi2String token, fmi2String location,
                                  const fmi2CallbackFunctions *functions) {
    void *const environment = (void *)(uintptr_t)functions;
    const fmi3LogMessageCallback logger = functions->logger != NULL ? log_of_fmi3 : NULL;
    if (type == fmi2ModelExchange)
        return three.InstantiateModelExchange(name, token, location, false, false, environment, logger);
    const fmi3ValueReference torque = is_inverse() ? 0 : reference("tau");
    const size_t required = intermediate_update != NULL && !is_inverse() ? 1 : 0;
    return three.InstantiateCoSimulation(name, token, location, false, false, false, false, &torque, required,
                                         environment, logger, (fmi3IntermediateUpdateCallback)intermediate_update);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String location,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean loggingOn) {
    begin();
    const fmi2Component c = version3 ? instantiate3(name, type, token, location, functions)
                                     : two.Instantiate(name, type, token, location, functions, visible, loggingOn);
    end();
    return c;
}

void fmi2FreeInstance(fmi2Component c) {
    begin();
    if (version3) three.FreeInstance(c);
    else two.FreeInstance(c);
    end();
}

/* FMI 3.0 sets up the experiment with the next call. */
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
    if (version3) return fmi2OK;
    begin();
    return ended2(two.SetupExperiment(c, toleranceDefined, tolerance, startTime, stopTimeDefined, stopTime));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    begin();
    if (version3) return ended3(three.EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0));
    return ended2(two.EnterInitializationMode(c));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    begin();
    return version3 ? ended3(three.ExitInitializationMode(c)) : ended2(two.ExitInitializationMode(c));
}

fmi2Status fmi2Terminate(fmi2Component c) {
    begin();
    return version3 ? ended3(three.Terminate(c)) : ended2(two.Terminate(c));
}

fmi2Status fmi2Reset(fmi2Component c) {
    begin();
    return version3 ? ended3(three.Reset(c)) : ended2(two.Reset(c));
}

/* ---- variables ---- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    begin();
    return version3 ? ended3(three.GetFloat64(c, vr, n, value, n)) : ended2(two.GetReal(c, vr, n, value));
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    begin();
    return version3 ? ended3(three.GetInt32(c, vr, n, value, n)) : ended2(two.GetInteger(c, vr, n, value));
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    begin();
    return version3 ? ended3(three.SetFloat64(c, vr, n, value, n)) : ended2(two.SetReal(c, vr, n, value));
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    begin();
    return version3 ? ended3(three.SetInt32(c, vr, n, value, n)) : ended2(two.SetInteger(c, vr, n, value));
}

/* The checks set one Boolean at a time. */
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    const fmi3Boolean first = value[0] != fmi2False;
    begin();
    return version3 ? ended3(three.SetBoolean(c, vr, n, &first, n)) : ended2(two.SetBoolean(c, vr, n, value));
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    begin();
    return version3 ? ended3(three.SetString(c, vr, n, value, n)) : ended2(two.SetString(c, vr, n, value));
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
                                        const fmi2ValueReference known[], size_t knowns, const fmi2Real seed[],
                                        fmi2Real product[]) {
    begin();
    if (version3)
        return ended3(
            three.GetDirectionalDerivative(c, unknown, unknowns, known, knowns, seed, knowns, product, unknowns));
    return ended2(two.GetDirectionalDerivative(c, unknown, unknowns, known, knowns, seed, product));
}

/* FMI 3.0 has no derivatives of inputs. */
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    if (version3) return fmi2OK;
    begin();
    return ended2(two.SetRealInputDerivatives(c, vr, n, order, value));
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[]) {
    begin();
    if (version3) return ended3(three.GetOutputDerivatives(c, vr, n, order, value, n));
    return ended2(two.GetRealOutputDerivatives(c, vr, n, order, value));
}

/* ---- states ---- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    begin();
    return version3 ? ended3(three.GetFMUState(c, state)) : ended2(two.GetFMUstate(c, state));
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    begin();
    return version3 ? ended3(three.SetFMUState(c, state)) : ended2(two.SetFMUstate(c, state));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    begin();
    return version3 ? ended3(three.FreeFMUState(c, state)) : ended2(two.FreeFMUstate(c, state));
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    begin();
    if (version3) return ended3(three.SerializedFMUStateSize(c, state, size));
    return ended2(two.SerializedFMUstateSize(c, state, size));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    begin();
    if (version3) return ended3(three.SerializeFMUState(c, state, (fmi3Byte *)bytes, size));
    return ended2(two.SerializeFMUstate(c, state, bytes, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    begin();
    if (version3) return ended3(three.DeserializeFMUState(c, (const fmi3Byte *)bytes, size, state));
    return ended2(two.DeSerializeFMUstate(c, bytes, size, state));
}

/* ---- steps and events ---- */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean goes_on) {
    fmi3Boolean event, terminate, early;
    fmi3Float64 reached;
    begin();
    if (version3) return ended3(three.DoStep(c, t, h, goes_on != fmi2False, &event, &terminate, &early, &reached));
    return ended2(two.DoStep(c, t, h, goes_on));
}

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    begin();
    return version3 ? ended3(three.EnterEventMode(c)) : ended2(two.EnterEventMode(c));
}

/* The checks look at newDiscreteStatesNeeded alone. */
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    begin();
    if (!version3) return ended2(two.NewDiscreteStates(c, info));
    fmi3Boolean needed = true, terminate, nominals, values, defined;
    fmi3Float64 next;
    const fmi3Status status = three.UpdateDiscreteStates(c, &needed, &terminate, &nominals, &values, &defined, &next);
    info->newDiscreteStatesNeeded = needed;
    return ended3(status);
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    begin();
    return version3 ? ended3(three.EnterContinuousTimeMode(c)) : ended2(two.EnterContinuousTimeMode(c));
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean goes_on, fmi2Boolean *event,
                                       fmi2Boolean *terminate) {
    begin();
    if (!version3) return ended2(two.CompletedIntegratorStep(c, goes_on, event, terminate));
    fmi3Boolean enter, finish;
    const fmi3Status status = three.CompletedIntegratorStep(c, goes_on != fmi2False, &enter, &finish);
    *event = enter, *terminate = finish;
    return ended3(status);
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    begin();
    return version3 ? ended3(three.SetTime(c, time)) : ended2(two.SetTime(c, time));
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    begin();
    return version3 ? ended3(three.SetContinuousStates(c, x, n)) : ended2(two.SetContinuousStates(c, x, n));
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    begin();
    return version3 ? ended3(three.GetContinuousStates(c, x, n)) : ended2(two.GetContinuousStates(c, x, n));
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real rate[], size_t n) {
    begin();
    if (version3) return ended3(three.GetContinuousStateDerivatives(c, rate, n));
    return ended2(two.GetDerivatives(c, rate, n));
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicator[], size_t n) {
    begin();
    if (version3) return ended3(three.GetEventIndicators(c, indicator, n));
    return ended2(two.GetEventIndicators(c, indicator, n));
}
