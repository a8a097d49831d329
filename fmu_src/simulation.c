#include "simulation.h"

#include <math.h>
#include <string.h>

/* A master adds up its time on its own; it may differ from ours by this share. */
static const double TIME_ROUNDING = 1e-12;

/* ---- co-simulation ---- */

static bool is_step(const Instance *instance, const char *function, double t, double h) {
    const double time = instance->run.time;
    if (!(h > 0.0 && isfinite(h)))
        return instance_refuse(instance, "%s: communicationStepSize = %.17g: allowed is any finite number > 0",
                               function, h);
    return (isfinite(t + h) && fabs(t - time) <= TIME_ROUNDING * fmax(h, fmax(fabs(t), fabs(time)))) ||
           instance_refuse(instance, "%s: currentCommunicationPoint = %.17g: allowed is only the FMU's time, %.17g",
                           function, t, time);
}

bool simulation_step(Instance *instance, const char *function, double t, double h) {
    if (!instance_is_in(instance, function, PHASE_STEP) || !is_step(instance, function, t, h)) return false;
    Machine *machine = &instance->values.machine;
    const MachineInputs before = machine->inputs;
    if (instance->run.with_rates == 0) model_forget_rates(&machine->inputs);
    Fault fault;
    if (!model_advance(machine, h, instance->run.with_rates, &fault)) {
        machine->inputs = before;
        return instance_refuse(instance, "%s: %s", function, fault.text);
    }
    instance->run.time = t + h;
    instance->run.with_rates = 0;
    instance_changed(instance);
    return true;
}

/* ---- model exchange ---- */

bool simulation_begin(Instance *instance, const char *function) {
    if (instance == NULL || instance->run.use == CO_SIMULATION) return instance_begin(instance, function, PHASE_STEP);
    Fault fault;
    if (!instance_begin(instance, function, PHASE_EVENT)) return false;
    if (model_begin_exchange(&instance->values.machine, &fault)) return true;
    instance->run.phase = PHASE_INITIALIZATION;
    return instance_refuse(instance, "%s: %s", function, fault.text);
}

static bool is_vector(const Instance *instance, const char *function, unsigned phases, const double x[], size_t n,
                      size_t expected) {
    if (!instance_is_in(instance, function, phases)) return false;
    if (n != expected)
        return instance_refuse(instance, "%s: %zu elements asked for: allowed are only %zu", function, n, expected);
    return instance_has_array(instance, function, n, x, "the array");
}

bool simulation_set_time(Instance *instance, const char *function, double time) {
    if (!instance_is_in(instance, function, PHASE_EVENT | PHASE_CONTINUOUS)) return false;
    if (!isfinite(time))
        return instance_refuse(instance, "%s: time = %.17g: allowed is any finite number", function, time);
    instance->run.time = time;
    return true;
}

bool simulation_set_states(Instance *instance, const char *function, const double x[], size_t n) {
    if (!is_vector(instance, function, PHASE_CONTINUOUS, x, n, CONTINUOUS_STATES)) return false;
    for (size_t i = 0; i < n; i++)
        if (!isfinite(x[i]))
            return instance_refuse(instance, "%s: %s = %.17g: allowed is any finite number", function,
                                   VARIABLES[model_state_reference((int)i)].name, x[i]);
    model_set_states(&instance->values.machine, x);
    instance_changed(instance);
    return true;
}

enum { PHASES_OF_READING = PHASE_INITIALIZATION | PHASES_RUNNING | PHASE_TERMINATED };

bool simulation_get_states(Instance *instance, const char *function, double x[], size_t n) {
    if (!is_vector(instance, function, PHASES_OF_READING, x, n, CONTINUOUS_STATES) ||
        !instance_provide(instance, function, GROUP_STATE))
        return false;
    model_get_states(&instance->values.machine, x);
    return true;
}

bool simulation_get_rates(Instance *instance, const char *function, double rate[], size_t n) {
    Fault fault;
    if (!is_vector(instance, function, PHASES_OF_READING, rate, n, CONTINUOUS_STATES) ||
        !instance_provide(instance, function, GROUP_STATE))
        return false;
    return model_state_rates(&instance->values.machine, rate, &fault) ||
           instance_refuse(instance, "%s: %s", function, fault.text);
}

bool simulation_get_indicators(Instance *instance, const char *function, double indicator[], size_t n) {
    if (!is_vector(instance, function, PHASES_OF_READING, indicator, n, EVENT_INDICATORS) ||
        !instance_provide(instance, function, GROUP_STATE))
        return false;
    model_indicators(&instance->values.machine, indicator);
    return true;
}

bool simulation_get_nominals(Instance *instance, const char *function, double nominal[], size_t n) {
    if (!is_vector(instance, function, ~0u, nominal, n, CONTINUOUS_STATES)) return false;
    for (size_t i = 0; i < n; i++) nominal[i] = VARIABLES[model_state_reference((int)i)].nominal;
    return true;
}

bool simulation_accept(Instance *instance, const char *function) {
    if (!instance_is_in(instance, function, PHASE_CONTINUOUS)) return false;
    Fault fault;
    if (!model_accept(&instance->values.machine, instance->run.time - instance->run.accepted, &fault))
        return instance_refuse(instance, "%s: %s", function, fault.text);
    instance->run.accepted = instance->run.time;
    instance_changed(instance);
    return true;
}

bool simulation_settle(Instance *instance, const char *function, bool *moved) {
    if (!instance_is_in(instance, function, PHASE_EVENT)) return false;
    Machine *machine = &instance->values.machine;
    double before[CONTINUOUS_STATES + 1], after[CONTINUOUS_STATES + 1];
    Fault fault;
    model_get_states(machine, before);
    if (!model_settle(machine, &fault)) return instance_refuse(instance, "%s: %s", function, fault.text);
    model_get_states(machine, after);
    *moved = memcmp(before, after, CONTINUOUS_STATES * sizeof(double)) != 0;
    instance_changed(instance);
    return true;
}
