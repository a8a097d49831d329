/* The functions that FMI 2.0 and FMI 3.0 have in common, but for the prefix of their names. */
#include "fmi/fmi.h"
#include "fmi/fmu_state.h"
#include "fmi/simulation.h"

/* Inside a step the call is refused: the step needs the instance until it returns. */
void FMI(FreeInstance)(void *instance) {
    if (instance == NULL || !instance_is_in(instance, __func__, ~(unsigned)PHASES_INSIDE_STEP)) return;
    instance_free(instance);
}

Status FMI(SetDebugLogging)(void *instance, Boolean on, size_t count, const Text categories[]) {
    return status_of(instance_set_logging(instance, __func__, on != 0, count, categories));
}

Status FMI(ExitInitializationMode)(void *instance) {
    return status_of(instance_exit_initialization(instance, __func__));
}

Status FMI(Terminate)(void *instance) {
    return status_of(instance_change_phase(instance, __func__, PHASES_RUNNING, PHASE_TERMINATED));
}

Status FMI(Reset)(void *instance) {
    if (!instance_is_in(instance, __func__, ~(unsigned)PHASES_INSIDE_STEP)) return status_of(false);
    instance_reset(instance);
    return status_of(true);
}

/* ---- states ---- */

Status FMI_STATE(Get, )(void *instance, void **state) {
    return status_of(fmu_state_get(instance, __func__, state));
}

Status FMI_STATE(Set, )(void *instance, void *state) {
    return status_of(fmu_state_set(instance, __func__, state));
}

Status FMI_STATE(Free, )(void *instance, void **state) {
    return status_of(fmu_state_free(instance, __func__, state));
}

Status FMI_STATE(Serialized, Size)(void *instance, void *state, size_t *size) {
    return status_of(fmu_state_size(instance, __func__, state, size));
}

Status FMI_STATE(Serialize, )(void *instance, void *state, Byte bytes[], size_t size) {
    return status_of(fmu_state_serialize(instance, __func__, state, bytes, size));
}

/* ---- model exchange ---- */

Status FMI(CompletedIntegratorStep)(void *instance, Boolean without_return, Boolean *enterEventMode,
                                    Boolean *terminateSimulation) {
    (void)without_return;
    const bool good = instance != NULL && instance_has_pointer(instance, __func__, enterEventMode, "enterEventMode") &&
                      instance_has_pointer(instance, __func__, terminateSimulation, "terminateSimulation") &&
                      simulation_complete_integrator_step(instance, __func__);
    if (good) *enterEventMode = *terminateSimulation = 0;
    return status_of(good);
}

Status FMI(SetContinuousStates)(void *instance, const double x[], size_t n) {
    return status_of(simulation_set_states(instance, __func__, x, n));
}

Status FMI(GetContinuousStates)(void *instance, double x[], size_t n) {
    return status_of(simulation_get_states(instance, __func__, x, n));
}

Status FMI(GetEventIndicators)(void *instance, double indicator[], size_t n) {
    return status_of(simulation_get_indicators(instance, __func__, indicator, n));
}
