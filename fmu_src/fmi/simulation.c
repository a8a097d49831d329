#include "fmi/simulation.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "fmi/access.h"

/* A master adds up its time on its own; it may differ from ours by this share. */
static const double TIME_ROUNDING = 1e-12;

/* ---- co-simulation ---- */

static bool is_near(double t, double time, double h) {
    return fabs(t - time) <= TIME_ROUNDING * fmax(h, fmax(fabs(t), fabs(time)));
}

static bool is_step(const Instance *instance, const char *function, double t, double h) {
    const double time = instance->run.time;
    if (!(h > 0.0 && h <= DBL_MAX))
        return instance_refuse(instance, "%s: communicationStepSize = %.17g: allowed is any finite number > 0",
                               function, h);
    return (fabs(t + h) <= DBL_MAX && (t == time || is_near(t, time, h))) ||
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

/* ---- a master that takes part in a step ---- */

typedef struct {
    Watcher watcher; /* first: all that the machine knows of it */
    Instance *instance;
    Visitor *visitor;
    double end; /* s, of the step */
    bool event; /* the mode changes there */
} Follower;

static double visit(const Follower *f, double time, Phase phase) {
    Instance *instance = f->instance;
    const Visit here = {
        .time = time,
        .asks_for_inputs = phase == PHASE_SAMPLING,
        .may_end = phase == PHASE_WATCHING && instance->following.takes_early_return && time < f->end,
    };
    instance->run.time = time;
    instance->run.phase = phase;
    instance_changed(instance);
    const double wanted = f->visitor(instance, &here);
    instance->run.phase = PHASE_STEP;
    return here.may_end ? fmin(fmax(wanted, time), f->end) : f->end;
}

/* See Watcher. */
static double follow_change(Watcher *watcher, double left) {
    Follower *f = (Follower *)watcher;
    const Instance *instance = f->instance;
    const double end = f->end, now = end - left;
    if (left > 0.0 && instance->run.use == HYBRID_CO_SIMULATION && instance->following.takes_early_return) f->end = now;
    else if (left > 0.0 && f->visitor != NULL) f->end = visit(f, now, PHASE_WATCHING);
    const double on = f->end == end ? left : fmin(f->end - now, left);
    f->event = on == 0.0;
    return on;
}

/* A difference of values that is nothing but their rounding, as that of a constant or a ramp would be. */
static double significant(double difference, double size) {
    return fabs(difference) > 8.0 * DBL_EPSILON * size ? difference : 0.0;
}

/* Derivatives at the start of the cubic through u[0] to u[3], `third` seconds apart (Newton's forward differences). */
static void differentiate(const double u[4], double third, double derivative[4]) {
    const double size = fmax(fmax(fabs(u[0]), fabs(u[1])), fmax(fabs(u[2]), fabs(u[3])));
    const double d1 = u[1] - u[0];
    const double d2 = significant(u[2] - 2.0 * u[1] + u[0], size);
    const double d3 = significant(u[3] - 3.0 * (u[2] - u[1]) - u[0], size);
    derivative[0] = u[0];
    derivative[1] = (d1 - d2 / 2.0 + d3 / 3.0) / third;
    derivative[2] = (d2 - d3) / third / third;
    derivative[3] = d3 / third / third / third;
}

_Static_assert(INPUT_ORDER == 3, "cubics");

/* Inputs from the master's values at the thirds of the step. */
static bool sample(const Follower *f, const char *function, double t, double h) {
    enum { INPUTS_MAX = 16 };
    Instance *instance = f->instance;
    const double third = h / 3.0;
    double u[INPUTS_MAX][INPUT_ORDER + 1];
    for (int k = 0; k <= INPUT_ORDER; k++) {
        if (k > 0) (void)visit(f, k < INPUT_ORDER ? t + k * third : f->end, PHASE_SAMPLING);
        for (unsigned r = 0; r < INPUTS_MAX; r++)
            if (instance->following.sampled >> r & 1u) u[r][k] = access_input(instance, r)[0];
    }
    for (unsigned r = 0; r < INPUTS_MAX; r++) {
        if ((instance->following.sampled >> r & 1u) == 0) continue;
        double *input = access_input(instance, r);
        differentiate(u[r], third, input);
        if (!isfinite(input[1] + input[2] + input[3]))
            return instance_refuse(instance, "%s: %s changes within %.17g s by more than allowed: finite derivatives",
                                   function, VARIABLES[r].name, h);
        instance->run.with_rates |= (uint16_t)(1u << r);
    }
    return true;
}

static bool advance(Follower *f, const char *function, double t, double h) {
    Instance *instance = f->instance;
    Machine *machine = &instance->values.machine;
    model_forget_rates(&machine->inputs);
    if (f->visitor != NULL && instance->following.sampled != 0 && !sample(f, function, t, h)) return false;
    Fault fault;
    return model_advance_watched(machine, h, instance->run.with_rates, &f->watcher, &fault) ||
           instance_refuse(instance, "%s: %s", function, fault.text);
}

bool simulation_follow(Instance *instance, const char *function, double t, double h, Visitor *visitor, StepEnd *end) {
    if (!instance_is_in(instance, function, PHASE_STEP) || !is_step(instance, function, t, h)) return false;
    *end = (StepEnd){.time = t + h};
    if (visitor == NULL && instance->run.use == CO_SIMULATION) return simulation_step(instance, function, t, h);
    Follower f = {.watcher = {.changed = follow_change}, .instance = instance, .visitor = visitor, .end = t + h};
    const MachineInputs inputs = instance->values.machine.inputs;
    const Run run = instance->run;
    if (!advance(&f, function, t, h)) {
        instance->values.machine.inputs = inputs;
        instance->run = run;
        instance_changed(instance);
        return false;
    }
    instance->run.time = f.end;
    instance->run.with_rates = 0;
    instance_changed(instance);
    if (visitor != NULL) (void)visit(&f, f.end, PHASE_WATCHING);
    *end = (StepEnd){
        .time = f.end,
        .early = f.end < t + h,
        .event = f.event && instance->run.use == HYBRID_CO_SIMULATION,
    };
    return true;
}

/* ---- model exchange ---- */

bool simulation_begin(Instance *instance, const char *function) {
    const bool is_plain = instance != NULL && instance->run.use == CO_SIMULATION;
    if (!instance_begin(instance, function, is_plain ? PHASE_STEP : PHASE_EVENT)) return false;
    Fault fault;
    if (instance->run.use != MODEL_EXCHANGE || model_begin_exchange(&instance->values.machine, &fault)) return true;
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
    if (!instance_is_in(instance, function, PHASE_EVENT | PHASE_CONTINUOUS) ||
        !instance_is_for(instance, function, MODEL_EXCHANGE))
        return false;
    if (!isfinite(time))
        return instance_refuse(instance, "%s: time = %.17g: allowed is any finite number", function, time);
    instance->run.time = time;
    instance->valid &= ~(unsigned)GROUP_TIME;
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
    for (size_t i = 0; i < n; i++) nominal[i] = variable_nominal(&VARIABLES[model_state_reference((int)i)]);
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
