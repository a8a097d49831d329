#include "fmi/simulation.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "elementary/elementary.h"
#include "fmi/access.h"
#include "numerics/tolerances.h"
#include "platform/arithmetic.h"

/* ---- co-simulation ---- */

static bool is_near(double t, double time, double h) {
    return fabs(t - time) <= TIME_ROUNDING * max_of(h, max_of(fabs(t), fabs(time)));
}

static bool is_step(const Instance *instance, const char *function, double t, double h) {
    const double time = instance->run.time;
    if (!(h > 0.0 && h <= DBL_MAX))
        return instance_refuse(instance, "%s: communicationStepSize = %s: allowed is any finite number > 0", function,
                               shortest_decimal(h).text);
    return (fabs(t + h) <= DBL_MAX && (t == time || is_near(t, time, h))) ||
           instance_refuse(instance, "%s: currentCommunicationPoint = %s: allowed is only the FMU's time, %s", function,
                           shortest_decimal(t).text, shortest_decimal(time).text);
}

/* ---- a step in which the master takes part ---- */

typedef struct {
    Watcher watcher; /* the first member: the model knows only this one */
    Instance *instance;
    IntermediateUpdate *update;
    HostArithmetic host; /* in which the master's update runs */
    double begin, end;   /* s, of the step */
    bool early, event;   /* the step ends before its time; the mode changes at the end */
} WatchedStep;

/* Calls the master's update in this phase. Returns the end of the step, s. */
static double call_update(const WatchedStep *step, double time, Phase phase) {
    Instance *instance = step->instance;
    const IntermediatePoint point = {
        .time = time,
        .inputs_requested = phase == PHASE_INTERMEDIATE_INPUTS,
        .may_end =
            phase == PHASE_INTERMEDIATE_OUTPUTS && instance->intermediate.early_return_allowed && time < step->end,
    };
    instance->run.time = time;
    instance->run.phase = phase;
    instance_invalidate(instance);
    const double wanted = step->update(instance, &point);
    instance->run.phase = PHASE_STEP;
    return point.may_end ? min_of(max_of(wanted, time), step->end) : step->end;
}

/* The same from within the model. */
static double leave_for_update(WatchedStep *step, double time) {
    arithmetic_end(step->host);
    const double end = call_update(step, time, PHASE_INTERMEDIATE_OUTPUTS);
    step->host = arithmetic_begin();
    return end;
}

/* Watcher.changed: the mode has changed, `left` seconds before the end of the step. */
static double mode_changed(Watcher *watcher, double left) {
    WatchedStep *step = (WatchedStep *)watcher;
    const Instance *instance = step->instance;
    const bool handles_events = instance->run.interface_type == INTERFACE_HYBRID_CO_SIMULATION;
    /* in a step as long as 1e16 s the time of the change rounds to seconds: it must not round to before the step */
    const double end = step->end, now = max_of(end - left, step->begin);
    if (left > 0.0 && handles_events && instance->intermediate.early_return_allowed) step->end = now;
    else if (left > 0.0 && step->update != NULL) step->end = leave_for_update(step, now);
    if (step->end != end) step->early = true;
    const double remaining = step->end == end ? left : min_of(step->end - now, left);
    step->event = remaining == 0.0;
    return remaining;
}

static double significant(double difference, double size) {
    return fabs(difference) > INPUT_ROUNDING * size ? difference : 0.0;
}

/* Derivatives at the start of the cubic through u[0] to u[3], `third` seconds apart (Newton's forward differences). */
static void differentiate(const double u[4], double third, double derivative[4]) {
    const double size = max_of(max_of(fabs(u[0]), fabs(u[1])), max_of(fabs(u[2]), fabs(u[3])));
    const double d1 = u[1] - u[0];
    const double d2 = significant(u[2] - 2.0 * u[1] + u[0], size);
    const double d3 = significant(u[3] - 3.0 * (u[2] - u[1]) - u[0], size);
    derivative[0] = u[0];
    derivative[1] = (d1 - d2 / 2.0 + d3 / 3.0) / third;
    derivative[2] = (d2 - d3) / third / third;
    derivative[3] = d3 / third / third / third;
}

_Static_assert(INPUT_ORDER == 3, "the inputs are cubics");

/* Sets the derivatives of the sampled inputs from the master's values at the thirds of the step. */
static bool sample_inputs(const WatchedStep *step, double t, double h, Fault *fault) {
    Instance *instance = step->instance;
    const double third = h / 3.0;
    double u[INPUTS_MAX][INPUT_ORDER + 1];
    for (int k = 0; k <= INPUT_ORDER; k++) {
        if (k > 0) (void)call_update(step, k < INPUT_ORDER ? t + k * third : step->end, PHASE_INTERMEDIATE_INPUTS);
        for (unsigned r = 0; r < INPUTS_MAX; r++)
            if (instance_samples(instance, r)) u[r][k] = access_input(instance, r)[0];
    }
    for (unsigned r = 0; r < INPUTS_MAX; r++) {
        if (!instance_samples(instance, r)) continue;
        double *input = access_input(instance, r);
        const HostArithmetic host = arithmetic_begin();
        differentiate(u[r], third, input);
        arithmetic_end(host);
        if (!isfinite(input[1] + input[2] + input[3])) {
            snprintf(fault->text, sizeof fault->text, "%s changes within %s s by more than allowed: finite derivatives",
                     VARIABLES[r].name, shortest_decimal(h).text);
            return false;
        }
        instance->run.derivatives_given |= (uint16_t)(1u << r);
    }
    return true;
}

static bool advance(WatchedStep *step, double t, double h, Fault *fault) {
    Instance *instance = step->instance;
    FmuModel *model = &instance->values.model;
    if (instance->run.derivatives_given == 0) model_clear_input_derivatives(&model->inputs);
    const bool samples = step->update != NULL && instance->intermediate.sampled_inputs != 0;
    if (samples && !sample_inputs(step, t, h, fault)) return false;
    const bool watches = step->update != NULL || instance->run.interface_type == INTERFACE_HYBRID_CO_SIMULATION;
    step->host = arithmetic_begin();
    step->end = t + h;
    const bool good = model_advance(model, h, instance->run.derivatives_given, watches ? &step->watcher : NULL, fault);
    arithmetic_end(step->host);
    return good;
}

bool simulation_step(Instance *instance, const char *function, double t, double h, IntermediateUpdate *update,
                     StepEnd *end) {
    if (!instance_is_in(instance, function, PHASE_STEP) || !is_step(instance, function, t, h)) return false;
    WatchedStep step = {
        .watcher = {.changed = mode_changed}, .instance = instance, .update = update, .begin = t, .end = t + h};
    const ModelInputs inputs = instance->values.model.inputs;
    const Run run = instance->run;
    Fault fault;
    if (!advance(&step, t, h, &fault)) {
        instance->values.model.inputs = inputs;
        instance->run = run;
        instance_invalidate(instance);
        return instance_refuse(instance, "%s: %s", function, fault.text);
    }
    instance->run.time = step.end;
    instance->run.derivatives_given = 0;
    instance_invalidate(instance);
    if (update != NULL) (void)call_update(&step, step.end, PHASE_INTERMEDIATE_OUTPUTS);
    *end = (StepEnd){
        .time = step.end,
        .early = step.early,
        .event = step.event && instance->run.interface_type == INTERFACE_HYBRID_CO_SIMULATION,
    };
    return true;
}

/* ---- model exchange ---- */

static bool is_vector(const Instance *instance, const char *function, unsigned phases, const double x[], size_t n,
                      size_t expected) {
    if (!instance_has_interface(instance, function, INTERFACE_MODEL_EXCHANGE) ||
        !instance_is_in(instance, function, phases))
        return false;
    if (n != expected)
        return instance_refuse(instance, "%s: %zu elements asked for: allowed are only %zu", function, n, expected);
    return instance_has_array(instance, function, n, x, "the array");
}

bool simulation_set_time(Instance *instance, const char *function, unsigned phases, double time) {
    if (!instance_has_interface(instance, function, INTERFACE_MODEL_EXCHANGE) ||
        !instance_is_in(instance, function, phases))
        return false;
    if (!isfinite(time))
        return instance_refuse(instance, "%s: time = %s: allowed is any finite number", function,
                               shortest_decimal(time).text);
    instance->run.time = time;
    instance->valid &= ~(unsigned)GROUP_TIME;
    return true;
}

bool simulation_set_states(Instance *instance, const char *function, const double x[], size_t n) {
    if (!is_vector(instance, function, PHASE_CONTINUOUS, x, n, CONTINUOUS_STATES)) return false;
    for (size_t i = 0; i < n; i++)
        if (!isfinite(x[i]))
            return instance_refuse(instance, "%s: %s = %s: allowed is any finite number", function,
                                   VARIABLES[model_state_reference((int)i)].name, shortest_decimal(x[i]).text);
    const HostArithmetic host = arithmetic_begin();
    model_set_states(&instance->values.model, x);
    arithmetic_end(host);
    instance_invalidate(instance);
    return true;
}

bool simulation_get_states(Instance *instance, const char *function, double x[], size_t n) {
    if (!is_vector(instance, function, PHASES_OF_RESULTS, x, n, CONTINUOUS_STATES) ||
        !instance_provide(instance, function, GROUP_STATE))
        return false;
    model_get_states(&instance->values.model, x);
    return true;
}

static bool are_numbers(const Instance *instance, const char *function, const double x[], size_t n) {
    for (size_t i = 0; i < n; i++)
        if (isnan(x[i]))
            return instance_refuse(instance,
                                   "%s: element %zu is no number: allowed are states and inputs for which it is finite",
                                   function, i);
    return true;
}

bool simulation_get_derivatives(Instance *instance, const char *function, double derivative[], size_t n) {
    Fault fault;
    if (!is_vector(instance, function, PHASES_OF_RESULTS, derivative, n, CONTINUOUS_STATES) ||
        !instance_provide(instance, function, GROUP_STATE))
        return false;
    const HostArithmetic host = arithmetic_begin();
    const bool good = model_state_derivatives(&instance->values.model, derivative, &fault);
    arithmetic_end(host);
    if (!good) return instance_refuse(instance, "%s: %s", function, fault.text);
    return are_numbers(instance, function, derivative, n);
}

bool simulation_get_indicators(Instance *instance, const char *function, double indicator[], size_t n) {
    if (!is_vector(instance, function, PHASES_OF_RESULTS, indicator, n, EVENT_INDICATORS) ||
        !instance_provide(instance, function, GROUP_STATE))
        return false;
    const HostArithmetic host = arithmetic_begin();
    model_indicators(&instance->values.model, indicator);
    arithmetic_end(host);
    return are_numbers(instance, function, indicator, n);
}

bool simulation_get_nominals(Instance *instance, const char *function, unsigned phases, double nominal[], size_t n) {
    if (!is_vector(instance, function, phases, nominal, n, CONTINUOUS_STATES)) return false;
    for (size_t i = 0; i < n; i++) nominal[i] = LIMITS[model_state_reference((int)i)].nominal;
    return true;
}

bool simulation_complete_integrator_step(Instance *instance, const char *function) {
    if (!instance_is_in(instance, function, PHASE_CONTINUOUS)) return false;
    Fault fault;
    const HostArithmetic host = arithmetic_begin();
    const double h = instance->run.time - instance->run.completed_until;
    const bool good = model_complete_integrator_step(&instance->values.model, h, &fault);
    arithmetic_end(host);
    if (!good) return instance_refuse(instance, "%s: %s", function, fault.text);
    instance->run.completed_until = instance->run.time;
    instance_invalidate(instance);
    return true;
}

bool simulation_update_discrete_states(Instance *instance, const char *function, bool *states_changed) {
    if (!instance_is_in(instance, function, PHASE_EVENT)) return false;
    FmuModel *model = &instance->values.model;
    double before[CONTINUOUS_STATES + 1], after[CONTINUOUS_STATES + 1]; /* no array of length 0 in C */
    model_get_states(model, before);
    const HostArithmetic host = arithmetic_begin();
    model_update_discrete_states(model);
    arithmetic_end(host);
    model_get_states(model, after);
    *states_changed = memcmp(before, after, CONTINUOUS_STATES * sizeof(double)) != 0;
    instance_invalidate(instance);
    return true;
}
