/* The functions of FMI 3.0 that the FMU only refuses: scheduled execution, structural parameters, further types of
 * variables, and clocks. */
#include "fmi/fmi.h"

#include "platform/attributes.h"

/* ---- scheduled execution and configuration ---- */

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String instantiationToken,
                                               fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                               fmi3InstanceEnvironment instanceEnvironment,
                                               fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
                                               fmi3LockPreemptionCallback lockPreemption,
                                               fmi3UnlockPreemptionCallback unlockPreemption) {
    (void)instanceName, (void)instantiationToken, (void)resourcePath, (void)visible, (void)loggingOn;
    (void)clockUpdate, (void)lockPreemption, (void)unlockPreemption;
    const Log log = fmi3_log(instanceEnvironment, logMessage);
    log.send(&log, "", MESSAGE_ERROR,
             "fmi3InstantiateScheduledExecution: allowed are fmi3InstantiateCoSimulation and "
             "fmi3InstantiateModelExchange");
    return NULL;
}

/* Configuration mode is for structural parameters. */
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

/* fmi3UpdateDiscreteStates() computes the discrete states; nothing is to be iterated before. */
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) {
    if (instance == NULL) return fmi3Error;
    return status_of(instance_refuse(instance, "%s is not provided: allowed is fmi3UpdateDiscreteStates", __func__));
}

/* ---- types that no variable has ---- */

/* Only an empty list of variables can be read or set: no variable is of such a type. */
static fmi3Status refuse_type(const Instance *instance, const char *function, size_t n) {
    if (instance == NULL) return fmi3Error;
    return status_of(n == 0 || instance_refuse(instance,
                                               "%s: no variable has this type: allowed are Float64, Int32, Boolean "
                                               "and String",
                                               function));
}

fmi3Status fmi3GetFloat32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Float32 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetFloat32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Float32 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3GetInt8(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                       fmi3Int8 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetInt8(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                       const fmi3Int8 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3GetUInt8(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3UInt8 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetUInt8(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3UInt8 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3GetInt16(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Int16 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetInt16(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Int16 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3GetUInt16(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         fmi3UInt16 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetUInt16(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         const fmi3UInt16 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3GetUInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         fmi3UInt32 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetUInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         const fmi3UInt32 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Int64 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Int64 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3GetUInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         fmi3UInt64 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

fmi3Status fmi3SetUInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         const fmi3UInt64 values[], size_t nValues) {
    (void)valueReferences, (void)values, (void)nValues;
    return refuse_type(instance, __func__, nValueReferences);
}

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

/* ---- clocks ---- */

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
    if (instance == NULL) return fmi3Error;
    return status_of(
        instance_refuse(instance, "%s: there is no scheduled execution: allowed is not to call it", __func__));
}
