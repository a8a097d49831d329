/* The functions of FMI 2.0, co-simulation and model exchange.
 *
 * A call that returns fmi2Error or fmi2Discard has logged one message that says what is allowed, and has changed
 * nothing: the instance goes on as before. The standard would end the run there (section 2.1.3). This file translates
 * the types and names of FMI 2.0; access.h, derivatives.h, simulation.h and fmu_state.h do the work. */
#include <stdio.h>

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
COLD static void send_message(const Log *log, const char *name, fmi2Status status, MessageKind kind, const char *text) {
    const fmi2CallbackLogger logger = (fmi2CallbackLogger)log->logger;
    if (logger == NULL) return;
    char message[2048];
    escape_message(message, sizeof message, text, "%#");
    logger(log->environment, name, status, MESSAGE_CATEGORIES[kind], message);
}

COLD static void log_message(const Log *log, const char *name, MessageKind kind, const char *text) {
    send_message(log, name, kind == MESSAGE_ERROR ? fmi2Error : fmi2Warning, kind, text);
}

/* `loggingOn` concerns debug messages. There are none; errors and warnings are always logged. */
fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn) {
    (void)visible, (void)loggingOn;
    Log log = {.send = log_message};
    if (functions != NULL) {
        log.logger = (void (*)(void))functions->logger;
        log.environment = functions->componentEnvironment;
    }
    if (fmuType != fmi2ModelExchange && fmuType != fmi2CoSimulation) {
        log.send(&log, instanceName != NULL ? instanceName : "", MESSAGE_ERROR,
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

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
    return status_of(instance_setup(c, __func__, toleranceDefined != fmi2False ? &tolerance : NULL, startTime,
                                    stopTimeDefined != fmi2False ? &stopTime : NULL));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    return status_of(instance_change_phase(c, __func__, PHASE_INSTANTIATED, PHASE_INITIALIZATION));
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
    return status_of(derivatives_product(c, __func__, &jacobian, false, dvKnown, dvUnknown));
}

/* ---- states ---- */

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate) {
    return status_of(fmu_state_deserialize(c, __func__, serializedState, size, FMUstate));
}

/* ---- co-simulation ---- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    return status_of(derivatives_set_of_inputs(c, __func__, vr, nvr, order, value));
}

/* The standard has the call in co-simulation alone, where values may be read. Every instance knows the derivatives. */
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[]) {
    return status_of(derivatives_get_of_outputs(c, __func__, ~0u, vr, nvr, order, value));
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint) {
    (void)noSetFMUStatePriorToCurrentPoint;
    StepEnd end;
    return status_of(simulation_step(c, __func__, currentCommunicationPoint, communicationStepSize, NULL, &end));
}

/* fmi2DoStep returns when the step is done, so no step is ever pending. */
fmi2Status fmi2CancelStep(fmi2Component c) {
    if (c == NULL) return fmi2Error;
    return status_of(instance_refuse(c, "%s: no step is ever pending: allowed is not to call it", __func__));
}

/* Of a kind that has no answer: between steps of co-simulation fmi2Discard (section 4.2.3), elsewhere fmi2Error. */
COLD static fmi2Status discard_status(const Instance *instance, const char *function, fmi2StatusKind kind,
                                      const void *value) {
    if (!instance_is_co_simulation(instance, function) || !instance_is_in(instance, function, PHASE_STEP) ||
        !instance_has_pointer(instance, function, value, "value"))
        return fmi2Error;
    char text[256];
    snprintf(text, sizeof text,
             "%s: status kind %d has no answer, no step is ever pending: allowed are fmi2LastSuccessfulTime with "
             "fmi2GetRealStatus and fmi2Terminated with fmi2GetBooleanStatus",
             function, (int)kind);
    if (instance->logs[MESSAGE_ERROR]) send_message(&instance->log, instance->name, fmi2Discard, MESSAGE_ERROR, text);
    return fmi2Discard;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value) {
    return discard_status(c, __func__, s, value);
}

/* The standard has the call between steps alone. The FMU knows the time in every state. */
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value) {
    const Instance *instance = c;
    if (instance == NULL || s != fmi2LastSuccessfulTime) return discard_status(instance, __func__, s, value);
    if (!instance_has_pointer(instance, __func__, value, "value")) return fmi2Error;
    *value = instance->run.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value) {
    return discard_status(c, __func__, s, value);
}

/* The FMU never asks for the end of the simulation, in whatever state the master calls. */
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value) {
    const Instance *instance = c;
    if (instance == NULL || s != fmi2Terminated) return discard_status(instance, __func__, s, value);
    if (!instance_has_pointer(instance, __func__, value, "value")) return fmi2Error;
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value) {
    return discard_status(c, __func__, s, value);
}

/* ---- model exchange ---- */

/* In event mode the call is allowed, too (section 3.2.3), and has no effect. */
fmi2Status fmi2EnterEventMode(fmi2Component c) {
    return status_of(instance_change_phase(c, __func__, PHASE_CONTINUOUS | PHASE_EVENT, PHASE_EVENT));
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

/* FMI 2.0.1 allows the call in event mode to FMUs without continuous states alone; FMI 2.0 allowed it to all. */
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    return status_of(simulation_set_time(c, __func__, PHASE_CONTINUOUS | PHASE_EVENT, time));
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx) {
    return status_of(simulation_get_derivatives(c, __func__, derivatives, nx));
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx) {
    return status_of(simulation_get_nominals(c, __func__, ~0u, x_nominal, nx));
}
