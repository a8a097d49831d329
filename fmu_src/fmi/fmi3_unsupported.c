/* The functions of FMI 3.0 that the FMU only refuses: scheduled execution, structural parameters, further types of
 * variables, and clocks. */
#include "fmi/fmi.h"

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

/* `unused`: casts to void of the parameters in `...`. */
#define REFUSE(name, unused, ...)                                                                                      \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, __VA_ARGS__) {                     \
        (void)vr, unused;                                                                                              \
        return refuse_type(instance, __func__, n);                                                                     \
    }

#define REFUSE_TYPE(type)                                                                                              \
    REFUSE(fmi3Get##type, ((void)values, (void)count), fmi3##type values[], size_t count)                              \
    REFUSE(fmi3Set##type, ((void)values, (void)count), const fmi3##type values[], size_t count)

REFUSE_TYPE(Float32)
REFUSE_TYPE(Int8)
REFUSE_TYPE(UInt8)
REFUSE_TYPE(Int16)
REFUSE_TYPE(UInt16)
REFUSE_TYPE(UInt32)
REFUSE_TYPE(Int64)
REFUSE_TYPE(UInt64)
REFUSE(fmi3GetBinary, ((void)sizes, (void)values, (void)count), size_t sizes[], fmi3Binary values[], size_t count)
REFUSE(fmi3SetBinary, ((void)sizes, (void)values, (void)count), const size_t sizes[], const fmi3Binary values[],
       size_t count)

/* ---- clocks ---- */

REFUSE(fmi3GetClock, (void)values, fmi3Clock values[])
REFUSE(fmi3SetClock, (void)values, const fmi3Clock values[])
REFUSE(fmi3GetIntervalDecimal, ((void)values, (void)qualifiers), fmi3Float64 values[],
       fmi3IntervalQualifier qualifiers[])
REFUSE(fmi3SetIntervalDecimal, (void)values, const fmi3Float64 values[])
REFUSE(fmi3GetIntervalFraction, ((void)counters, (void)resolutions, (void)qualifiers), fmi3UInt64 counters[],
       fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
REFUSE(fmi3SetIntervalFraction, ((void)counters, (void)resolutions), const fmi3UInt64 counters[],
       const fmi3UInt64 resolutions[])
REFUSE(fmi3GetShiftDecimal, (void)values, fmi3Float64 values[])
REFUSE(fmi3SetShiftDecimal, (void)values, const fmi3Float64 values[])
REFUSE(fmi3GetShiftFraction, ((void)counters, (void)resolutions), fmi3UInt64 counters[], fmi3UInt64 resolutions[])
REFUSE(fmi3SetShiftFraction, ((void)counters, (void)resolutions), const fmi3UInt64 counters[],
       const fmi3UInt64 resolutions[])

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clockReference,
                                      fmi3Float64 activationTime) {
    (void)clockReference, (void)activationTime;
    if (instance == NULL) return fmi3Error;
    return status_of(
        instance_refuse(instance, "%s: there is no scheduled execution: allowed is not to call it", __func__));
}
