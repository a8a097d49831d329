/* The functions of FMI 2.0, co-simulation and model exchange.
 *
 * A call that returns fmi2Error has logged one message that says what is allowed, and has changed nothing: the instance
 * goes on as before. This file translates the types and names of FMI 2.0; access.h, derivatives.h, simulation.h and
 * fmu_state.h do the work. */
#include "fmi/access.h"
#include "fmi/derivatives.h"
#include "fmi/fmi.h"
#include "fmi/fmu_state.h"
#include "fmi/simulation.h"
#include "platform/attributes.h"

const char *fmi2GetTypesPlatform(void) {
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void) {
    return fmi2Version;
}

/* ---- life ---- */

/* FMI 2.0 reads a message as a printf format with #...# for variables, but not all masters expand it. With % and #
 * doubled the text is right where it is expanded, and readable where it is not. */
COLD static void log_error(const Log *log, const char *name, const char *text) {
    const fmi2CallbackLogger logger = (fmi2CallbackLogger)log->logger;
    if (logger == NULL) return;
    char message[2048];
    escape_message(message, sizeof message, text, "%#");
    logger(log->environment, name, fmi2Error, ERROR_CATEGORY, message);
}

/* `loggingOn` concerns debug messages. There are none, and errors are always logged. */
fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn) {
    (void)visible, (void)loggingOn;
    Log log = {.error = log_error};
    if (functions != NULL) {
        log.logger = (void (*)(void))functions->logger;
        log.environment = functions->componentEnvironment;
    }
    if (fmuType != fmi2ModelExchange && fmuType != fmi2CoSimulation) {
        log.error(&log, instanceName != NULL ? instanceName : "",
                  "fmi2Instantiate: fmuType: allowed are fmi2ModelExchange and fmi2CoSimulation");
        return NULL;
    }
    const InstanceRequest request = {
        .function = __func__,
        .name = instanceName,
        .guid = fmuGUID,
        .guid_name = "fmuGUID",
        .location = fmuResourceLocation,
        .interface_type = fmuType == fmi2ModelExchange ? INTERFACE_MODEL_EXCHANGE : INTERFACE_CO_SIMULATION,
    };
    return instance_new(&request, &log);
}

void fmi2FreeInstance(fmi2Component c) {
    instance_free(c);
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[]) {
    return status_of(instance_set_logging(c, __func__, loggingOn != fmi2False, nCategories, categories));
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
    return status_of(instance_setup(c, __func__, toleranceDefined != fmi2False ? &tolerance : NULL, startTime,
                                    stopTimeDefined != fmi2False ? &stopTime : NULL));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    return status_of(instance_change_phase(c, __func__, PHASE_INSTANTIATED, PHASE_INITIALIZATION));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    return status_of(instance_exit_initialization(c, __func__));
}

fmi2Status fmi2Terminate(fmi2Component c) {
    return status_of(instance_change_phase(c, __func__, PHASES_RUNNING, PHASE_TERMINATED));
}

fmi2Status fmi2Reset(fmi2Component c) {
    if (c == NULL) return fmi2Error;
    instance_reset(c);
    return fmi2OK;
}

/* ---- variables ---- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[]) {
    return status_of(access_get_reals(c, __func__, vr, nvr, value));
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[]) {
    return status_of(access_get_integers(c, __func__, vr, nvr, value));
}

static void write_boolean(void *value, size_t i, bool content) {
    ((fmi2Boolean *)value)[i] = content ? fmi2True : fmi2False;
}

/* Every number other than 0 is true: masters send 1 and -1. */
static bool read_boolean(const void *value, size_t i) {
    return ((const fmi2Boolean *)value)[i] != fmi2False;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[]) {
    return status_of(access_get_booleans(c, __func__, vr, nvr, value, write_boolean));
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[]) {
    return status_of(access_get_texts(c, __func__, vr, nvr, value));
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[]) {
    return status_of(access_set_reals(c, __func__, vr, nvr, value));
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[]) {
    return status_of(access_set_integers(c, __func__, vr, nvr, value));
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[]) {
    return status_of(access_set_booleans(c, __func__, vr, nvr, value, read_boolean));
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2String value[]) {
    return status_of(access_set_texts(c, __func__, vr, nvr, value));
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[], size_t nUnknown,
                                        const fmi2ValueReference vKnown_ref[], size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[]) {
    const Jacobian jacobian = {vUnknown_ref, vKnown_ref, nUnknown, nKnown};
    return status_of(derivatives_directional(c, __func__, &jacobian, dvKnown, dvUnknown));
}

/* ---- states ---- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    return status_of(fmu_state_get(c, __func__, FMUstate));
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) {
    return status_of(fmu_state_set(c, __func__, FMUstate));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    return status_of(fmu_state_free(c, __func__, FMUstate));
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size) {
    return status_of(fmu_state_size(c, __func__, FMUstate, size));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size) {
    return status_of(fmu_state_serialize(c, __func__, FMUstate, serializedState, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate) {
    return status_of(fmu_state_deserialize(c, __func__, serializedState, size, FMUstate));
}

/* ---- co-simulation ---- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    return status_of(derivatives_set_of_inputs(c, __func__, vr, nvr, order, value));
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[]) {
    return status_of(derivatives_get_of_outputs(c, __func__, vr, nvr, order, value));
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint) {
    (void)noSetFMUStatePriorToCurrentPoint;
    return status_of(simulation_step(c, __func__, currentCommunicationPoint, communicationStepSize));
}

/* fmi2DoStep returns when the step is done, so no step is ever pending. */
fmi2Status fmi2CancelStep(fmi2Component c) {
    if (c == NULL) return fmi2Error;
    return status_of(instance_refuse(c, "%s: no step is ever pending: allowed is not to call it", __func__));
}

static fmi2Status refuse_status(const Instance *instance, const char *function, fmi2StatusKind kind) {
    if (instance == NULL) return fmi2Error;
    return status_of(instance_refuse(
        instance,
        "%s: status kind %d has no answer, no step is ever pending: allowed are fmi2LastSuccessfulTime with "
        "fmi2GetRealStatus and fmi2Terminated with fmi2GetBooleanStatus",
        function, (int)kind));
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value) {
    (void)value;
    return refuse_status(c, __func__, s);
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value) {
    const Instance *instance = c;
    if (instance == NULL || s != fmi2LastSuccessfulTime) return refuse_status(instance, __func__, s);
    if (!instance_has_pointer(instance, __func__, value, "value")) return fmi2Error;
    *value = instance->run.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value) {
    (void)value;
    return refuse_status(c, __func__, s);
}

/* The FMU never asks for the end of the simulation. */
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value) {
    const Instance *instance = c;
    if (instance == NULL || s != fmi2Terminated) return refuse_status(instance, __func__, s);
    if (!instance_has_pointer(instance, __func__, value, "value")) return fmi2Error;
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value) {
    (void)value;
    return refuse_status(c, __func__, s);
}

/* ---- model exchange ---- */

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    return status_of(instance_change_phase(c, __func__, PHASE_CONTINUOUS, PHASE_EVENT));
}

/* One update is enough, and there are no time events. */
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo) {
    bool states_changed;
    if (c == NULL || !instance_has_pointer(c, __func__, eventInfo, "eventInfo") ||
        !simulation_update_discrete_states(c, __func__, &states_changed))
        return fmi2Error;
    *eventInfo = (fmi2EventInfo){
        .newDiscreteStatesNeeded = fmi2False,
        .terminateSimulation = fmi2False,
        .nominalsOfContinuousStatesChanged = fmi2False,
        .valuesOfContinuousStatesChanged = states_changed ? fmi2True : fmi2False,
        .nextEventTimeDefined = fmi2False,
    };
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    return status_of(instance_change_phase(c, __func__, PHASE_EVENT, PHASE_CONTINUOUS));
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation) {
    (void)noSetFMUStatePriorToCurrentPoint;
    if (c == NULL || !instance_has_pointer(c, __func__, enterEventMode, "enterEventMode") ||
        !instance_has_pointer(c, __func__, terminateSimulation, "terminateSimulation") ||
        !simulation_complete_integrator_step(c, __func__))
        return fmi2Error;
    *enterEventMode = *terminateSimulation = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    return status_of(simulation_set_time(c, __func__, time));
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx) {
    return status_of(simulation_set_states(c, __func__, x, nx));
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx) {
    return status_of(simulation_get_states(c, __func__, x, nx));
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx) {
    return status_of(simulation_get_derivatives(c, __func__, derivatives, nx));
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni) {
    return status_of(simulation_get_indicators(c, __func__, eventIndicators, ni));
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx) {
    return status_of(simulation_get_nominals(c, __func__, x_nominal, nx));
}
