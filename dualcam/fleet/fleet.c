#include "fleet.h"

#include "pool.h"
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    fmi2Component component; /* NULL: the FMU made none */
    double time;             /* s */
    char *text;              /* where a message goes: FLEET_TEXT bytes of the thread that calls */
    bool has_failed;
    bool is_new; /* instantiated, and not yet used */
} Slot;

struct Fleet {
    FleetFunctions functions;
    FleetExperiment experiment;
    fmi2CallbackFunctions callbacks; /* without environment: the part that all instances share */
    fmi2CallbackFunctions *own_callbacks;
    size_t count;
    Slot *slots;
    Pool *pool;
    char (*texts)[FLEET_TEXT]; /* [threads] */
    atomic_bool is_lost;       /* a call returned fmi2Fatal: FMI allows no further call of this FMU */
    FleetReport reports[FLEET_REPORTS];
    atomic_size_t failures;         /* of the present call */
    atomic_size_t failed_instances; /* number of slots with has_failed */
};

/* ---- jobs ---- */

/* Does one thing to instance i. Fatal or an error: the instance has failed. */
typedef fmi2Status Job(Fleet *fleet, size_t i, const void *arguments);

typedef struct {
    Fleet *fleet;
    Job *job;
    const void *arguments;
    const uint8_t *chosen;
    bool revives;       /* also of instances that have failed */
    size_t work_of_one; /* for pool_run */
} Call;

static bool is_success(fmi2Status status) {
    return status == fmi2OK || status == fmi2Warning;
}

static const char *name_of(fmi2Status status) {
    switch (status) {
        case fmi2OK: return "fmi2OK";
        case fmi2Warning: return "fmi2Warning";
        case fmi2Discard: return "fmi2Discard";
        case fmi2Error: return "fmi2Error";
        case fmi2Fatal: return "fmi2Fatal";
        case fmi2Pending: return "fmi2Pending";
    }
    return "an unknown status";
}

static void mark(Fleet *fleet, Slot *slot, bool has_failed) {
    if (slot->has_failed == has_failed) return;
    slot->has_failed = has_failed;
    if (has_failed) atomic_fetch_add(&fleet->failed_instances, 1);
    else atomic_fetch_sub(&fleet->failed_instances, 1);
}

static void report(Fleet *fleet, size_t i, fmi2Status status) {
    Slot *slot = &fleet->slots[i];
    mark(fleet, slot, true);
    if (status == fmi2Fatal) atomic_store(&fleet->is_lost, true);
    size_t place = atomic_fetch_add(&fleet->failures, 1);
    if (place >= FLEET_REPORTS) return;
    fleet->reports[place].instance = i;
    if (slot->text[0] == '\0')
        snprintf(slot->text, FLEET_TEXT, "the FMU returned %s, without a message", name_of(status));
    memcpy(fleet->reports[place].text, slot->text, FLEET_TEXT);
}

static void do_instances(void *context, size_t first, size_t last, unsigned worker) {
    const Call *call = context;
    Fleet *fleet = call->fleet;
    char *text = fleet->texts[worker];
    for (size_t i = first; i < last; i++) {
        Slot *slot = &fleet->slots[i];
        if (call->chosen != NULL && call->chosen[i] == 0) continue;
        if (slot->has_failed && !call->revives) continue;
        if (atomic_load_explicit(&fleet->is_lost, memory_order_relaxed)) return;
        text[0] = '\0';
        slot->text = text;
        fmi2Status status = call->job(fleet, i, call->arguments);
        if (is_success(status)) mark(fleet, slot, false);
        else report(fleet, i, status);
    }
}

static long finish(Fleet *fleet, Call call) {
    if (atomic_load(&fleet->is_lost)) return FLEET_FATAL;
    atomic_store(&fleet->failures, 0);
    pool_run(fleet->pool, do_instances, &call, fleet->count, call.work_of_one > 0 ? call.work_of_one : 1);
    return atomic_load(&fleet->is_lost) ? FLEET_FATAL : (long)atomic_load(&fleet->failures);
}

/* ---- life ---- */

/* fmi2CallbackLogger. `environment` is the slot; messages of one call are joined. */
static void keep_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                         fmi2String message, ...) {
    (void)name;
    (void)category;
    (void)status;
    const Slot *slot = environment;
    if (slot == NULL || slot->text == NULL || message == NULL) return;
    size_t used = strlen(slot->text);
    if (used > 0 && used + 2 < FLEET_TEXT) {
        memcpy(slot->text + used, "; ", 3);
        used += 2;
    }
    va_list arguments;
    va_start(arguments, message);
    vsnprintf(slot->text + used, FLEET_TEXT - used, message, arguments);
    va_end(arguments);
}

static bool fill(Fleet *fleet, unsigned threads) {
    size_t count = fleet->count;
    fleet->slots = calloc(count, sizeof *fleet->slots);
    fleet->own_callbacks = calloc(count, sizeof *fleet->own_callbacks);
    fleet->texts = calloc(threads, sizeof *fleet->texts);
    if (fleet->slots == NULL || fleet->own_callbacks == NULL || fleet->texts == NULL) return false;
    fleet->pool = pool_new(threads);
    return fleet->pool != NULL;
}

Fleet *fleet_open(const FleetFunctions *functions, const FleetExperiment *experiment, size_t count, unsigned threads) {
    Fleet *fleet = calloc(1, sizeof *fleet);
    if (fleet == NULL) return NULL;
    fleet->functions = *functions;
    fleet->experiment = *experiment;
    fleet->count = count;
    if (fill(fleet, threads)) return fleet;
    fleet_close(fleet);
    return NULL;
}

void fleet_close(Fleet *fleet) {
    if (fleet == NULL) return;
    for (size_t i = 0; fleet->slots != NULL && i < fleet->count; i++) {
        Slot *slot = &fleet->slots[i];
        slot->text = NULL;
        if (slot->component != NULL && !atomic_load(&fleet->is_lost)) fleet->functions.free_instance(slot->component);
    }
    pool_free(fleet->pool);
    free(fleet->texts);
    free(fleet->own_callbacks);
    free(fleet->slots);
    free(fleet);
}

static fmi2Status instantiate(Fleet *fleet, size_t i, const void *arguments) {
    (void)arguments;
    const FleetExperiment *experiment = &fleet->experiment;
    Slot *slot = &fleet->slots[i];
    /* FMI 2.0 has the callbacks as constant members */
    fmi2CallbackFunctions callbacks = {keep_message, calloc, free, NULL, slot};
    memcpy(&fleet->own_callbacks[i], &callbacks, sizeof callbacks);
    slot->component =
        fleet->functions.instantiate(experiment->model, fmi2CoSimulation, experiment->guid, experiment->resources,
                                     &fleet->own_callbacks[i], fmi2False, fmi2False);
    slot->is_new = true;
    return slot->component != NULL ? fmi2OK : fmi2Error;
}

/* One after the other: FMUs that start an interpreter, or read files, may not be made in several threads. */
long fleet_instantiate(Fleet *fleet) {
    atomic_store(&fleet->failures, 0);
    Call call = {.fleet = fleet, .job = instantiate};
    do_instances(&call, 0, fleet->count, 0);
    return (long)atomic_load(&fleet->failures);
}

/* ---- values ---- */

static fmi2Status set_values(const Fleet *fleet, size_t i, const FleetValues *values) {
    const FleetFunctions *f = &fleet->functions;
    fmi2Component component = fleet->slots[i].component;
    fmi2Status status = fmi2OK;
    if (values->string_count > 0)
        status = f->set_string(component, values->string_references, values->string_count,
                               values->strings + i * values->string_count);
    if (is_success(status) && values->integer_count > 0)
        status = f->set_integer(component, values->integer_references, values->integer_count,
                                values->integers + i * values->integer_count);
    if (is_success(status) && values->boolean_count > 0)
        status = f->set_boolean(component, values->boolean_references, values->boolean_count,
                                values->booleans + i * values->boolean_count);
    if (is_success(status) && values->real_count > 0)
        status =
            f->set_real(component, values->real_references, values->real_count, values->reals + i * values->real_count);
    return status;
}

static fmi2Status start(Fleet *fleet, size_t i, const void *arguments) {
    const FleetFunctions *f = &fleet->functions;
    const FleetExperiment *experiment = &fleet->experiment;
    Slot *slot = &fleet->slots[i];
    if (slot->component == NULL) return fmi2Error;
    fmi2Status status = slot->is_new ? fmi2OK : f->reset(slot->component);
    slot->is_new = false;
    slot->time = experiment->start_time;
    if (is_success(status)) status = set_values(fleet, i, arguments);
    if (is_success(status))
        status = f->setup_experiment(slot->component, experiment->tolerance > 0.0, experiment->tolerance,
                                     experiment->start_time, fmi2False, 0.0);
    if (is_success(status)) status = f->enter_initialization(slot->component);
    if (is_success(status)) status = f->exit_initialization(slot->component);
    return status;
}

long fleet_start(Fleet *fleet, const FleetValues *values, const uint8_t *chosen) {
    return finish(fleet, (Call){.fleet = fleet, .job = start, .arguments = values, .chosen = chosen, .revives = true});
}

static fmi2Status set(Fleet *fleet, size_t i, const void *arguments) {
    return set_values(fleet, i, arguments);
}

long fleet_set(Fleet *fleet, const FleetValues *values, const uint8_t *chosen) {
    return finish(fleet, (Call){.fleet = fleet, .job = set, .arguments = values, .chosen = chosen});
}

typedef struct {
    fmi2ValueReference reference;
    double *reals;
    int *integers;
    int *booleans;
} Wanted;

static fmi2Status get(Fleet *fleet, size_t i, const void *arguments) {
    const Wanted *wanted = arguments;
    const FleetFunctions *f = &fleet->functions;
    fmi2Component component = fleet->slots[i].component;
    if (wanted->reals != NULL) return f->get_real(component, &wanted->reference, 1, wanted->reals + i);
    if (wanted->integers != NULL) return f->get_integer(component, &wanted->reference, 1, wanted->integers + i);
    return f->get_boolean(component, &wanted->reference, 1, wanted->booleans + i);
}

static long get_all(Fleet *fleet, Wanted wanted) {
    return finish(fleet, (Call){.fleet = fleet, .job = get, .arguments = &wanted});
}

long fleet_get_reals(Fleet *fleet, fmi2ValueReference reference, double *values) {
    return get_all(fleet, (Wanted){.reference = reference, .reals = values});
}

long fleet_get_integers(Fleet *fleet, fmi2ValueReference reference, int *values) {
    return get_all(fleet, (Wanted){.reference = reference, .integers = values});
}

long fleet_get_booleans(Fleet *fleet, fmi2ValueReference reference, int *values) {
    return get_all(fleet, (Wanted){.reference = reference, .booleans = values});
}

/* ---- steps ---- */

typedef struct {
    FleetPorts ports;
    const double *inputs;
    double *outputs;
    size_t steps;
    double size; /* s */
} Roll;

static fmi2Status step(const Fleet *fleet, Slot *slot, const Roll *roll, const double *inputs, double *outputs) {
    const FleetFunctions *f = &fleet->functions;
    const FleetPorts *ports = &roll->ports;
    fmi2Status status = fmi2OK;
    if (ports->input_count > 0)
        status = f->set_real(slot->component, ports->input_references, ports->input_count, inputs);
    if (is_success(status)) status = f->do_step(slot->component, slot->time, roll->size, fmi2True);
    if (!is_success(status)) return status;
    slot->time += roll->size;
    if (ports->output_count == 0) return fmi2OK;
    return f->get_real(slot->component, ports->output_references, ports->output_count, outputs);
}

static fmi2Status roll_one(Fleet *fleet, size_t i, const void *arguments) {
    const Roll *roll = arguments;
    size_t input_count = roll->ports.input_count, output_count = roll->ports.output_count;
    const double *inputs = roll->inputs + i * roll->steps * input_count;
    double *outputs = roll->outputs + i * roll->steps * output_count;
    for (size_t k = 0; k < roll->steps; k++) {
        fmi2Status status = step(fleet, &fleet->slots[i], roll, inputs + k * input_count, outputs + k * output_count);
        if (is_success(status)) continue;
        for (size_t j = k * output_count; j < roll->steps * output_count; j++) outputs[j] = NAN;
        return status;
    }
    return fmi2OK;
}

/* Reads the slots only where there is need: they are in the caches of the threads that step them. */
static void blank_failed(const Fleet *fleet, size_t width, double *outputs) {
    if (atomic_load(&fleet->failed_instances) == 0) return;
    for (size_t i = 0; i < fleet->count; i++) {
        if (!fleet->slots[i].has_failed) continue;
        for (size_t j = 0; j < width; j++) outputs[i * width + j] = NAN;
    }
}

/* Without a branch per number: the compiler makes vector instructions of the loop. */
static bool are_finite(const double *values, size_t count) {
    bool has_other = false;
    for (size_t k = 0; k < count; k++) has_other |= !(fabs(values[k]) <= DBL_MAX);
    return !has_other;
}

/* `width` inputs of each instance; those of instances that have failed are not used. */
static bool can_use(const Fleet *fleet, const double *inputs, size_t width) {
    if (are_finite(inputs, fleet->count * width)) return true;
    for (size_t i = 0; i < fleet->count; i++)
        if (!fleet->slots[i].has_failed && !are_finite(inputs + i * width, width)) return false;
    return true;
}

long fleet_roll(Fleet *fleet, const FleetPorts *ports, const double *inputs, size_t steps, double size,
                double *outputs) {
    if (!can_use(fleet, inputs, steps * ports->input_count)) return FLEET_NOT_FINITE;
    blank_failed(fleet, steps * ports->output_count, outputs);
    Roll roll = {.ports = *ports, .inputs = inputs, .outputs = outputs, .steps = steps, .size = size};
    long failures = finish(fleet, (Call){.fleet = fleet, .job = roll_one, .arguments = &roll, .work_of_one = steps});
    bool had_all_failed = failures == 0 && atomic_load(&fleet->failed_instances) == fleet->count;
    return had_all_failed ? FLEET_ALL_FAILED : failures;
}

/* ---- states ---- */

typedef struct {
    fmi2FMUstate *states;
    double *saved_times;
    const double *restored_times;
} States;

static fmi2Status save(Fleet *fleet, size_t i, const void *arguments) {
    const States *kept = arguments;
    kept->saved_times[i] = fleet->slots[i].time;
    return fleet->functions.get_state(fleet->slots[i].component, &kept->states[i]);
}

long fleet_save(Fleet *fleet, const uint8_t *chosen, fmi2FMUstate *states, double *times) {
    States kept = {.states = states, .saved_times = times};
    return finish(fleet, (Call){.fleet = fleet, .job = save, .arguments = &kept, .chosen = chosen});
}

static fmi2Status restore(Fleet *fleet, size_t i, const void *arguments) {
    const States *kept = arguments;
    if (fleet->slots[i].component == NULL || kept->states[i] == NULL) {
        snprintf(fleet->slots[i].text, FLEET_TEXT, "no state was saved: the instance had failed then");
        return fmi2Error;
    }
    fleet->slots[i].time = kept->restored_times[i];
    return fleet->functions.set_state(fleet->slots[i].component, kept->states[i]);
}

long fleet_restore(Fleet *fleet, const uint8_t *chosen, fmi2FMUstate *states, const double *times) {
    States kept = {.states = states, .restored_times = times};
    return finish(fleet, (Call){.fleet = fleet, .job = restore, .arguments = &kept, .chosen = chosen, .revives = true});
}

static fmi2Status free_state(Fleet *fleet, size_t i, const void *arguments) {
    const States *kept = arguments;
    return kept->states[i] == NULL ? fmi2OK : fleet->functions.free_state(fleet->slots[i].component, &kept->states[i]);
}

long fleet_free_states(Fleet *fleet, fmi2FMUstate *states) {
    atomic_store(&fleet->failures, 0);
    if (atomic_load(&fleet->is_lost)) return FLEET_FATAL;
    States kept = {.states = states};
    for (size_t i = 0; i < fleet->count; i++) free_state(fleet, i, &kept);
    return 0;
}

/* ---- what a caller can ask ---- */

void fleet_failed(const Fleet *fleet, uint8_t *failed) {
    for (size_t i = 0; i < fleet->count; i++) failed[i] = fleet->slots[i].has_failed;
}

void fleet_times(const Fleet *fleet, double *times) {
    for (size_t i = 0; i < fleet->count; i++) times[i] = fleet->slots[i].time;
}

size_t fleet_reports(const Fleet *fleet, const FleetReport **reports) {
    *reports = fleet->reports;
    size_t failures = atomic_load(&fleet->failures);
    return failures < FLEET_REPORTS ? failures : FLEET_REPORTS;
}
