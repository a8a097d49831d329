/* The functions of FMI 3.0, co-simulation and model exchange. What they promise: a call that returns fmi3Error has
 * logged one message that says what is allowed, and has changed nothing; the instance goes on as before it. Here
 * is only what FMI 3.0 has of its own: its types, and its words for what access.h, simulation.h and state_access.h
 * do. No physics here. */
#include "fmi3Functions.h"

#include <math.h>

#include "fmi/access.h"
#include "fmi/dependencies.h"
#include "fmi/simulation.h"
#include "fmi/state_access.h"

static fmi3Status status_of(bool good) {
    return good ? fmi3OK : fmi3Error;
}

const char *fmi3GetVersion(void) {
    return fmi3Version;
}

/* ---- life ---- */

/* In a message #...# stands for a variable, ## for #. */
static void escape(char *escaped, size_t size, const char *text) {
    size_t length = 0;
    for (const char *c = text; *c != '\0' && length + 3 <= size; c++) {
        if (*c == '#') escaped[length++] = *c;
        escaped[length++] = *c;
    }
    escaped[length] = '\0';
}

static void log_error(const Log *log, const char *name, const char *text) {
    (void)name; /* the environment tells instances apart */
    const fmi3LogMessageCallback logger = (fmi3LogMessageCallback)log->logger;
    if (logger == NULL) return;
    char message[2048];
    escape(message, sizeof message, text);
    logger(log->environment, fmi3Error, ERROR_CATEGORY, message);
}

static Log log_of(fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger) {
    return (Log){.error = log_error, .environment = environment, .logger = (void (*)(void))logger};
}

/* `loggingOn` is about debug messages, of which there are none: errors are always reported. */
fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage) {
    (void)visible, (void)loggingOn;
    const Log log = log_of(instanceEnvironment, logMessage);
    const Wish wish = {
        .function = __func__,
        .name = instanceName,
        .guid = instantiationToken,
        .guid_name = "instantiationToken",
        .path = resourcePath,
        .use = MODEL_EXCHANGE,
    };
    return instance_new(&wish, &log);
}

/* Reads which inputs the master gives inside steps; outputs may be in the list, too. */
static bool read_required(const fmi3ValueReference required[], size_t n, Following *following) {
    if (n > 0 && required == NULL) return false;
    for (size_t i = 0; i < n; i++) {
        const Variable *variable = variable_find(required[i]);
        if (variable == NULL) return false;
        if (SAMPLES_INPUTS && variable->causality == CAUSALITY_INPUT)
            following->sampled |= (uint16_t)(1u << required[i]);
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
    const Log log = log_of(instanceEnvironment, logMessage);
    Wish wish = {
        .function = __func__,
        .name = instanceName,
        .guid = instantiationToken,
        .guid_name = "instantiationToken",
        .path = resourcePath,
        .use = eventModeUsed ? HYBRID_CO_SIMULATION : CO_SIMULATION,
        .following = {.takes_early_return = earlyReturnAllowed && RETURNS_EARLY,
                      .update = (void (*)(void))intermediateUpdate},
    };
    if (!read_required(requiredIntermediateVariables, nRequiredIntermediateVariables, &wish.following)) {
        log.error(&log, "",
                  "fmi3InstantiateCoSimulation: requiredIntermediateVariables: allowed are variables with "
                  "intermediateUpdate = \"true\" in modelDescription.xml");
        return NULL;
    }
    return instance_new(&wish, &log);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String instantiationToken,
                                               fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                               fmi3InstanceEnvironment instanceEnvironment,
                                               fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
                                               fmi3LockPreemptionCallback lockPreemption,
                                               fmi3UnlockPreemptionCallback unlockPreemption) {
    (void)instanceName, (void)instantiationToken, (void)resourcePath, (void)visible, (void)loggingOn;
    (void)clockUpdate, (void)lockPreemption, (void)unlockPreemption;
    const Log log = log_of(instanceEnvironment, logMessage);
    log.error(&log, "",
              "fmi3InstantiateScheduledExecution: allowed are fmi3InstantiateCoSimulation and "
              "fmi3InstantiateModelExchange");
    return NULL;
}

/* Inside a step the instance is needed until that returns. */
void fmi3FreeInstance(fmi3Instance instance) {
    if (instance == NULL || !instance_is_in(instance, __func__, ~(unsigned)PHASES_INSIDE_STEP)) return;
    instance_free(instance);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[]) {
    return status_of(instance_set_logging(instance, __func__, loggingOn, nCategories, categories));
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime) {
    return status_of(instance_setup(instance, __func__, toleranceDefined ? &tolerance : NULL, startTime,
                                    stopTimeDefined ? &stopTime : NULL) &&
                     instance_go(instance, __func__, PHASE_INSTANTIATED, PHASE_INITIALIZATION));
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    return status_of(simulation_begin(instance, __func__));
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
    return status_of(instance_go(instance, __func__, PHASES_RUNNING, PHASE_TERMINATED));
}

fmi3Status fmi3Reset(fmi3Instance instance) {
    if (!instance_is_in(instance, __func__, ~(unsigned)PHASES_INSIDE_STEP)) return fmi3Error;
    instance_reset(instance);
    return fmi3OK;
}

/* There are no structural parameters. */
static fmi3Status refuse_configuration(const Instance *instance, const char *function) {
    if (instance == NULL) return fmi3Error;
    return status_of(
        instance_refuse(instance, "%s: there is no structural parameter: allowed is not to call it", function));
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance) {
    return refuse_configuration(instance, __func__);
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) {
    return refuse_configuration(instance, __func__);
}

/* ---- variables ---- */

/* One value per reference: there are no arrays. */
static bool is_count(const Instance *instance, const char *function, const char *name, size_t n, size_t expected) {
    if (instance == NULL) return false;
    return n == expected ||
           instance_refuse(instance, "%s: %s = %zu: allowed is %zu, as many as variables", function, name, n, expected);
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Float64 values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_get_reals(instance, __func__, valueReferences, nValueReferences, values));
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Float64 values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_set_reals(instance, __func__, valueReferences, nValueReferences, values));
}

fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Int32 values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_get_integers(instance, __func__, valueReferences, nValueReferences, values));
}

fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Int32 values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_set_integers(instance, __func__, valueReferences, nValueReferences, values));
}

static void write_boolean(void *value, size_t i, bool content) {
    ((fmi3Boolean *)value)[i] = content;
}

/* As a byte: one that is neither 0 nor 1 is no value of bool, and true. */
_Static_assert(sizeof(fmi3Boolean) == 1, "fmi3Boolean is a byte");
static bool read_boolean(const void *value, size_t i) {
    return ((const unsigned char *)value)[i] != 0;
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Boolean values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_get_booleans(instance, __func__, valueReferences, nValueReferences, values, write_boolean));
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Boolean values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_set_booleans(instance, __func__, valueReferences, nValueReferences, values, read_boolean));
}

fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         fmi3String values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_get_texts(instance, __func__, valueReferences, nValueReferences, values));
}

fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         const fmi3String values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_set_texts(instance, __func__, valueReferences, nValueReferences, values));
}

/* No variable is of another type: nothing can be read or set but nothing. */
static fmi3Status refuse_type(const Instance *instance, const char *function, size_t n) {
    if (instance == NULL) return fmi3Error;
    return status_of(n == 0 || instance_refuse(instance,
                                               "%s: no variable has this type: allowed are Float64, Int32, Boolean "
                                               "and String",
                                               function));
}

/* The functions of those types, which differ in nothing else. */
#define REFUSE_TYPE(type)                                                                                              \
    fmi3Status fmi3Get##type(fmi3Instance instance, const fmi3ValueReference valueReferences[],                        \
                             size_t nValueReferences, fmi3##type values[], size_t nValues) {                           \
        (void)valueReferences, (void)values, (void)nValues;                                                            \
        return refuse_type(instance, __func__, nValueReferences);                                                      \
    }                                                                                                                  \
    fmi3Status fmi3Set##type(fmi3Instance instance, const fmi3ValueReference valueReferences[],                        \
                             size_t nValueReferences, const fmi3##type values[], size_t nValues) {                     \
        (void)valueReferences, (void)values, (void)nValues;                                                            \
        return refuse_type(instance, __func__, nValueReferences);                                                      \
    }

REFUSE_TYPE(Float32)
REFUSE_TYPE(Int8)
REFUSE_TYPE(UInt8)
REFUSE_TYPE(Int16)
REFUSE_TYPE(UInt16)
REFUSE_TYPE(UInt32)
REFUSE_TYPE(Int64)
REFUSE_TYPE(UInt64)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         size_t valueSizes[], fmi3Binary values[], size_t nValues) {
    (void)valueReferences, (void)valueSizes, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         const size_t valueSizes[], const fmi3Binary values[], size_t nValues) {
    (void)valueReferences, (void)valueSizes, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

/* ---- clocks: none ---- */

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Clock values[]) {
    (void)valueReferences, (void)values;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Clock values[]) {
    (void)valueReferences, (void)values;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[]) {
    (void)valueReferences, (void)intervals, (void)qualifiers;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                   fmi3IntervalQualifier qualifiers[]) {
    (void)valueReferences, (void)counters, (void)resolutions, (void)qualifiers;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, fmi3Float64 shifts[]) {
    (void)valueReferences, (void)shifts;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[]) {
    (void)valueReferences, (void)counters, (void)resolutions;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, const fmi3Float64 intervals[]) {
    (void)valueReferences, (void)intervals;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, const fmi3UInt64 counters[],
                                   const fmi3UInt64 resolutions[]) {
    (void)valueReferences, (void)counters, (void)resolutions;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, const fmi3Float64 shifts[]) {
    (void)valueReferences, (void)shifts;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]) {
    (void)valueReferences, (void)counters, (void)resolutions;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clockReference,
                                      fmi3Float64 activationTime) {
    (void)clockReference, (void)activationTime;
    return refuse_type(instance, __func__, 1);
}

/* ---- dependencies ---- */

static const Dependency *next_dependency(const Dependency *row, fmi3ValueReference unknown) {
    while (row->unknown != VARIABLE_COUNT && row->unknown != unknown) row++;
    return row->unknown != VARIABLE_COUNT ? row : NULL;
}

/* The first of those that hold now, in *first: NULL if there is none. */
static bool find_dependencies(const Instance *instance, const char *function, fmi3ValueReference unknown,
                              const Dependency **first) {
    if (instance == NULL) return false;
    *first = next_dependency(DEPENDENCIES, unknown);
    if (*first == NULL && next_dependency(INITIAL_DEPENDENCIES, unknown) == NULL)
        return instance_refuse(instance, "%s: value reference %u: allowed are those of unknowns in ModelStructure",
                               function, unknown);
    if (!instance_has_begun(instance)) {
        const Dependency *initial = next_dependency(INITIAL_DEPENDENCIES, unknown);
        if (initial != NULL) *first = initial; /* event indicators have none of their own */
    }
    return true;
}

static size_t count_dependencies(const Dependency *row) {
    size_t n = 0;
    for (; row != NULL; row = next_dependency(row + 1, row->unknown)) n++;
    return n;
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference valueReference,
                                               size_t *nDependencies) {
    const Dependency *first;
    if (!find_dependencies(instance, __func__, valueReference, &first) ||
        !instance_has_pointer(instance, __func__, nDependencies, "nDependencies"))
        return fmi3Error;
    *nDependencies = count_dependencies(first);
    return fmi3OK;
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent,
                                       size_t elementIndicesOfDependent[], fmi3ValueReference independents[],
                                       size_t elementIndicesOfIndependents[], fmi3DependencyKind dependencyKinds[],
                                       size_t nDependencies) {
    const Dependency *row;
    if (!find_dependencies(instance, __func__, dependent, &row) ||
        !is_count(instance, __func__, "nDependencies", nDependencies, count_dependencies(row)) ||
        !instance_has_array(instance, __func__, nDependencies, elementIndicesOfDependent,
                            "elementIndicesOfDependent") ||
        !instance_has_array(instance, __func__, nDependencies, independents, "independents") ||
        !instance_has_array(instance, __func__, nDependencies, elementIndicesOfIndependents,
                            "elementIndicesOfIndependents") ||
        !instance_has_array(instance, __func__, nDependencies, dependencyKinds, "dependencyKinds"))
        return fmi3Error;
    for (size_t i = 0; row != NULL; i++, row = next_dependency(row + 1, dependent)) {
        elementIndicesOfDependent[i] = elementIndicesOfIndependents[i] = 0; /* the whole of a scalar */
        independents[i] = row->known;
        dependencyKinds[i] = row->kind == CONSTANT ? fmi3Constant : fmi3Dependent;
    }
    return fmi3OK;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                        size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity) {
    const Jacobian jacobian = {unknowns, knowns, nUnknowns, nKnowns};
    return status_of(is_count(instance, __func__, "nSeed", nSeed, nKnowns) &&
                     is_count(instance, __func__, "nSensitivity", nSensitivity, nUnknowns) &&
                     access_directional(instance, __func__, &jacobian, seed, sensitivity));
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                    size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity) {
    const Jacobian jacobian = {unknowns, knowns, nUnknowns, nKnowns};
    return status_of(is_count(instance, __func__, "nSeed", nSeed, nUnknowns) &&
                     is_count(instance, __func__, "nSensitivity", nSensitivity, nKnowns) &&
                     access_adjoint(instance, __func__, &jacobian, seed, sensitivity));
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t nValues) {
    return status_of(
        is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
        access_get_output_derivatives(instance, __func__, valueReferences, nValueReferences, orders, values));
}

/* ---- states ---- */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState) {
    return status_of(state_get(instance, __func__, FMUState));
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState) {
    return status_of(state_set(instance, __func__, FMUState));
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState) {
    return status_of(state_free(instance, __func__, FMUState));
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size) {
    return status_of(state_size(instance, __func__, FMUState, size));
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte serializedState[],
                                 size_t size) {
    return status_of(state_serialize(instance, __func__, FMUState, serializedState, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState *FMUState) {
    return status_of(state_deserialize(instance, __func__, serializedState, size, FMUState));
}

/* ---- co-simulation ---- */

/* The master's function is asked. Where it may not end the step, what it says of that does not count. */
static double update(Instance *instance, const Visit *here) {
    const fmi3IntermediateUpdateCallback callback = (fmi3IntermediateUpdateCallback)instance->following.update;
    fmi3Boolean requested = fmi3False;
    fmi3Float64 time = here->time;
    callback(instance->log.environment, here->time, here->asks_for_inputs, !here->asks_for_inputs,
             !here->asks_for_inputs, here->may_end, &requested, &time);
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
        !simulation_follow(me, __func__, currentCommunicationPoint, communicationStepSize,
                           me->following.update != NULL ? update : NULL, &end))
        return fmi3Error;
    *eventHandlingNeeded = end.event;
    *terminateSimulation = fmi3False;
    *earlyReturn = end.early;
    *lastSuccessfulTime = end.time;
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    return status_of(instance_is_for(instance, __func__, HYBRID_CO_SIMULATION) &&
                     instance_go(instance, __func__, PHASE_EVENT, PHASE_STEP));
}

/* ---- events ---- */

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    const Instance *const me = instance;
    if (me == NULL) return fmi3Error;
    if (me->run.use == MODEL_EXCHANGE) return status_of(instance_go(instance, __func__, PHASE_CONTINUOUS, PHASE_EVENT));
    return status_of(instance_is_for(instance, __func__, HYBRID_CO_SIMULATION) &&
                     instance_go(instance, __func__, PHASE_STEP, PHASE_EVENT));
}

/* Discrete states are those that fmi3UpdateDiscreteStates() finds; there is nothing to iterate before. */
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) {
    if (instance == NULL) return fmi3Error;
    return status_of(instance_refuse(instance, "%s is not provided: allowed is fmi3UpdateDiscreteStates", __func__));
}

/* One pass is enough, and there are no events in time. */
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation, fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged, fmi3Boolean *nextEventTimeDefined,
                                    fmi3Float64 *nextEventTime) {
    bool moved;
    if (instance == NULL ||
        !instance_has_pointer(instance, __func__, discreteStatesNeedUpdate, "discreteStatesNeedUpdate") ||
        !instance_has_pointer(instance, __func__, terminateSimulation, "terminateSimulation") ||
        !instance_has_pointer(instance, __func__, nominalsOfContinuousStatesChanged,
                              "nominalsOfContinuousStatesChanged") ||
        !instance_has_pointer(instance, __func__, valuesOfContinuousStatesChanged, "valuesOfContinuousStatesChanged") ||
        !instance_has_pointer(instance, __func__, nextEventTimeDefined, "nextEventTimeDefined") ||
        !instance_has_pointer(instance, __func__, nextEventTime, "nextEventTime") ||
        !simulation_settle(instance, __func__, &moved))
        return fmi3Error;
    *discreteStatesNeedUpdate = *terminateSimulation = *nominalsOfContinuousStatesChanged = fmi3False;
    *valuesOfContinuousStatesChanged = moved;
    *nextEventTimeDefined = fmi3False;
    *nextEventTime = 0.0;
    return fmi3OK;
}

/* ---- model exchange ---- */

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) {
    return status_of(instance_is_for(instance, __func__, MODEL_EXCHANGE) &&
                     instance_go(instance, __func__, PHASE_EVENT, PHASE_CONTINUOUS));
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation) {
    (void)noSetFMUStatePriorToCurrentPoint;
    if (instance == NULL || !instance_has_pointer(instance, __func__, enterEventMode, "enterEventMode") ||
        !instance_has_pointer(instance, __func__, terminateSimulation, "terminateSimulation") ||
        !simulation_accept(instance, __func__))
        return fmi3Error;
    *enterEventMode = *terminateSimulation = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) {
    return status_of(simulation_set_time(instance, __func__, time));
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates) {
    return status_of(simulation_set_states(instance, __func__, continuousStates, nContinuousStates));
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[], size_t nContinuousStates) {
    return status_of(simulation_get_states(instance, __func__, continuousStates, nContinuousStates));
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[],
                                             size_t nContinuousStates) {
    return status_of(simulation_get_rates(instance, __func__, derivatives, nContinuousStates));
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[], size_t nEventIndicators) {
    return status_of(simulation_get_indicators(instance, __func__, eventIndicators, nEventIndicators));
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t nContinuousStates) {
    return status_of(simulation_get_nominals(instance, __func__, nominals, nContinuousStates));
}

static fmi3Status write_count(const Instance *instance, const char *function, size_t *configuration, size_t count) {
    if (instance == NULL || !instance_has_pointer(instance, function, configuration, "the number")) return fmi3Error;
    *configuration = count;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators) {
    return write_count(instance, __func__, nEventIndicators, EVENT_INDICATORS);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates) {
    return write_count(instance, __func__, nContinuousStates, CONTINUOUS_STATES);
}
