/* The functions of FMI 3.0: life of an instance, FMU states, co-simulation, events and model exchange. Variables stand
 * in fmi3_variables.c, functions that the FMU only refuses in fmi3_unsupported.c.
 *
 * A call that returns fmi3Error has logged one message that says what is allowed, and has changed nothing: the
 * instance goes on as before. The standard would go to state Terminated (section 2.3.1). These files translate the
 * types and names of FMI 3.0; simulation.h and fmu_state.h do the work. */
#include <math.h>

#include "fmi/fmi.h"
#include "fmi/fmu_state.h"
#include "fmi/simulation.h"
#include "platform/attributes.h"

const char *fmi3GetVersion(void) {
    return fmi3Version;
}

/* ---- life ---- */

/* In a message of FMI, #...# stands for a variable, and ## for #. */
COLD static void log_message(const Log *log, const char *name, MessageKind kind, const char *text) {
    (void)name; /* the environment tells instances apart */
    const fmi3LogMessageCallback logger = (fmi3LogMessageCallback)log->logger;
    if (logger == NULL) return;
    char message[2048];
    escape_message(message, sizeof message, text, "#");
    logger(log->environment, kind == MESSAGE_ERROR ? fmi3Error : fmi3Warning, MESSAGE_CATEGORIES[kind], message);
}

Log fmi3_log(fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger) {
    return (Log){.send = log_message, .environment = environment, .logger = (void (*)(void))logger};
}

/* `loggingOn` concerns debug messages. There are none; errors and warnings are always logged. */
fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage) {
    (void)visible, (void)loggingOn;
    const Log log = fmi3_log(instanceEnvironment, logMessage);
    const InstanceRequest request = {
        .function = __func__,
        .name = instanceName,
        .guid = instantiationToken,
        .guid_name = "instantiationToken",
        .path = resourcePath,
        .interface_type = INTERFACE_MODEL_EXCHANGE,
    };
    return instance_new(&request, &log);
}

/* Reads which inputs the master sets inside steps. The list may hold outputs, too. */
static bool read_required(const fmi3ValueReference required[], size_t n, IntermediateAccess *intermediate) {
    if (n > 0 && required == NULL) return false;
    for (size_t i = 0; i < n; i++) {
        const Variable *variable = variable_find(required[i]);
        if (variable == NULL) return false;
        if (SAMPLES_INPUTS && variable->causality == CAUSALITY_INPUT)
            intermediate->sampled_inputs |= (uint16_t)(1u << required[i]);
        else if (variable->causality != CAUSALITY_OUTPUT) return false;
    }
    return true;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken,
                                         fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate) {
    (void)visible, (void)loggingOn;
    const Log log = fmi3_log(instanceEnvironment, logMessage);
    InstanceRequest request = {
        .function = __func__,
        .name = instanceName,
        .guid = instantiationToken,
        .guid_name = "instantiationToken",
        .path = resourcePath,
        .interface_type = eventModeUsed ? INTERFACE_HYBRID_CO_SIMULATION : INTERFACE_CO_SIMULATION,
        .intermediate = {.early_return_allowed = earlyReturnAllowed && RETURNS_EARLY,
                         .callback = (void (*)(void))intermediateUpdate},
    };
    if (!read_required(requiredIntermediateVariables, nRequiredIntermediateVariables, &request.intermediate)) {
        log.send(&log, "", MESSAGE_ERROR,
                 "fmi3InstantiateCoSimulation: requiredIntermediateVariables: allowed are variables with "
                 "intermediateUpdate = \"true\" in modelDescription.xml");
        return NULL;
    }
    return instance_new(&request, &log);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime) {
    return status_of(instance_setup(instance, __func__, toleranceDefined ? &tolerance : NULL, startTime,
                                    stopTimeDefined ? &stopTime : NULL) &&
                     instance_change_phase(instance, __func__, PHASE_INSTANTIATED, PHASE_INITIALIZATION));
}

/* ---- states ---- */

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState *FMUState) {
    return status_of(fmu_state_deserialize(instance, __func__, serializedState, size, FMUState));
}

/* ---- co-simulation ---- */

/* Calls the master's function. Its wish to end the step does not count where it may not end the step. */
static double intermediate_update(Instance *instance, const IntermediatePoint *point) {
    const fmi3IntermediateUpdateCallback callback = (fmi3IntermediateUpdateCallback)instance->intermediate.callback;
    fmi3Boolean requested = fmi3False;
    fmi3Float64 time = point->time;
    callback(instance->log.environment, point->time, point->inputs_requested, !point->inputs_requested,
             !point->inputs_requested, point->may_end, &requested, &time);
    return requested ? time : INFINITY;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime) {
    (void)noSetFMUStatePriorToCurrentPoint;
    Instance *const me = instance;
    StepEnd end;
    if (me == NULL || !instance_has_pointer(me, __func__, eventHandlingNeeded, "eventHandlingNeeded") ||
        !instance_has_pointer(me, __func__, terminateSimulation, "terminateSimulation") ||
        !instance_has_pointer(me, __func__, earlyReturn, "earlyReturn") ||
        !instance_has_pointer(me, __func__, lastSuccessfulTime, "lastSuccessfulTime") ||
        !simulation_step(me, __func__, currentCommunicationPoint, communicationStepSize,
                         me->intermediate.callback != NULL ? intermediate_update : NULL, &end))
        return fmi3Error;
    *eventHandlingNeeded = end.event;
    *terminateSimulation = fmi3False;
    *earlyReturn = end.early;
    *lastSuccessfulTime = end.time;
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    return status_of(instance_has_interface(instance, __func__, INTERFACE_HYBRID_CO_SIMULATION) &&
                     instance_change_phase(instance, __func__, PHASE_EVENT, PHASE_STEP));
}

/* ---- events ---- */

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    const Instance *const me = instance;
    if (me == NULL) return fmi3Error;
    if (me->run.interface_type == INTERFACE_MODEL_EXCHANGE)
        return status_of(instance_change_phase(instance, __func__, PHASE_CONTINUOUS, PHASE_EVENT));
    return status_of(instance_has_interface(instance, __func__, INTERFACE_HYBRID_CO_SIMULATION) &&
                     instance_change_phase(instance, __func__, PHASE_STEP, PHASE_EVENT));
}

/* One update is enough, and there are no time events. */
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation, fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged, fmi3Boolean *nextEventTimeDefined,
                                    fmi3Float64 *nextEventTime) {
    bool states_changed;
    if (instance == NULL ||
        !instance_has_pointer(instance, __func__, discreteStatesNeedUpdate, "discreteStatesNeedUpdate") ||
        !instance_has_pointer(instance, __func__, terminateSimulation, "terminateSimulation") ||
        !instance_has_pointer(instance, __func__, nominalsOfContinuousStatesChanged,
                              "nominalsOfContinuousStatesChanged") ||
        !instance_has_pointer(instance, __func__, valuesOfContinuousStatesChanged, "valuesOfContinuousStatesChanged") ||
        !instance_has_pointer(instance, __func__, nextEventTimeDefined, "nextEventTimeDefined") ||
        !instance_has_pointer(instance, __func__, nextEventTime, "nextEventTime") ||
        !simulation_update_discrete_states(instance, __func__, &states_changed))
        return fmi3Error;
    *discreteStatesNeedUpdate = *terminateSimulation = *nominalsOfContinuousStatesChanged = fmi3False;
    *valuesOfContinuousStatesChanged = states_changed;
    *nextEventTimeDefined = fmi3False;
    *nextEventTime = 0.0;
    return fmi3OK;
}

/* ---- model exchange ---- */

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) {
    return status_of(instance_has_interface(instance, __func__, INTERFACE_MODEL_EXCHANGE) &&
                     instance_change_phase(instance, __func__, PHASE_EVENT, PHASE_CONTINUOUS));
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) {
    return status_of(simulation_set_time(instance, __func__, PHASE_CONTINUOUS, time));
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[],
                                             size_t nContinuousStates) {
    return status_of(simulation_get_derivatives(instance, __func__, derivatives, nContinuousStates));
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t nContinuousStates) {
    return status_of(simulation_get_nominals(instance, __func__, PHASES_OF_RESULTS, nominals, nContinuousStates));
}

static fmi3Status write_count(const Instance *instance, const char *function, size_t *destination, size_t count) {
    if (!instance_has_interface(instance, function, INTERFACE_MODEL_EXCHANGE) ||
        !instance_has_pointer(instance, function, destination, "the number"))
        return fmi3Error;
    *destination = count;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators) {
    return write_count(instance, __func__, nEventIndicators, EVENT_INDICATORS);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates) {
    return write_count(instance, __func__, nContinuousStates, CONTINUOUS_STATES);
}
