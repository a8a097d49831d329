/* The functions of FMI 3.0 under the names of calls.h, except those in special_fmi3.c. */
#if FMI_VERSION == 3
#include <string.h>

#include "calls.h"
#include "fmi3Functions.h"
#include "guard.h"
#include "special_fmi3.h"

static bool is_ok(fmi3Status status) {
    return status == fmi3OK;
}

/* ---- life ---- */

static void log_message(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                        fmi3String message) {
    (void)status, (void)category;
    Run *run = environment;
    snprintf(run->message, sizeof run->message, "%s", message);
    run->messages++;
}

void call_instantiate(Run *run, Use use) {
    static const fmi3ValueReference announced[] = {0, 1, 2, 3}; /* inputs and outputs */
    const unsigned options = run->options;
    run->use = use;
    if (use == USE_MODEL_EXCHANGE)
        run->c = fmi3InstantiateModelExchange("fuzz", MODEL_GUID, directory(), false, true, run, log_message);
    else
        run->c = fmi3InstantiateCoSimulation("fuzz", MODEL_GUID, directory(), false, true, use == USE_HYBRID,
                                             options & 1, announced, SAMPLES_INPUTS && options & 2 ? 4 : 0, run,
                                             log_message, options & 4 ? intermediate_update : NULL);
    REQUIRE(run, run->c != NULL);
}

void call_free(Run *run) {
    fmi3FreeInstance(run->c);
}

bool call_enter_initialization(Run *run, const double *tolerance, double start, const double *stop) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard,
                     is_ok(fmi3EnterInitializationMode(run->c, tolerance != NULL, tolerance != NULL ? *tolerance : 0.0,
                                                       start, stop != NULL, stop != NULL ? *stop : 0.0)));
}

bool call_exit_initialization(Run *run) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3ExitInitializationMode(run->c)));
}

bool call_terminate(Run *run) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3Terminate(run->c)));
}

bool call_reset(Run *run) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3Reset(run->c)));
}

bool call_logging(Run *run, bool on, size_t n, const char *const categories[]) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3SetDebugLogging(run->c, on, n, (const fmi3String *)categories)));
}

/* ---- variables ---- */

bool call_get_reals(Run *run, const unsigned vr[], size_t n, double value[]) {
    const Guard guard = guard_begin(run);
    return guard_numbers(run, guard_end(run, guard, is_ok(fmi3GetFloat64(run->c, vr, n, value, n))), value, n);
}

bool call_get_integers(Run *run, const unsigned vr[], size_t n, int value[]) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3GetInt32(run->c, vr, n, value, n)));
}

bool call_get_booleans(Run *run, const unsigned vr[], size_t n) {
    fmi3Boolean value[MAX_REFERENCES];
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3GetBoolean(run->c, vr, n, value, n)));
}

bool call_get_texts(Run *run, const unsigned vr[], size_t n) {
    fmi3String value[MAX_REFERENCES];
    const Guard guard = guard_begin(run);
    const bool ok = guard_end(run, guard, is_ok(fmi3GetString(run->c, vr, n, value, n)));
    for (size_t i = 0; ok && i < n; i++) REQUIRE(run, strlen(value[i]) < 1024);
    return ok;
}

bool call_set_reals(Run *run, const unsigned vr[], size_t n, const double value[]) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3SetFloat64(run->c, vr, n, value, n)));
}

bool call_set_integers(Run *run, const unsigned vr[], size_t n, const int value[]) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3SetInt32(run->c, vr, n, value, n)));
}

bool call_set_booleans(Run *run, const unsigned vr[], size_t n, const int value[]) {
    fmi3Boolean boolean[MAX_REFERENCES];
    for (size_t i = 0; i < n && value != NULL; i++) boolean[i] = value[i] != 0;
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3SetBoolean(run->c, vr, n, value != NULL ? boolean : NULL, n)));
}

bool call_set_texts(Run *run, const unsigned vr[], size_t n, const char *const value[]) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3SetString(run->c, vr, n, (const fmi3String *)value, n)));
}

bool call_directional(Run *run, const unsigned unknown[], size_t unknowns, const unsigned known[], size_t knowns,
                      const double seed[], double product[]) {
    const Guard guard = guard_begin(run);
    const fmi3Status status =
        fmi3GetDirectionalDerivative(run->c, unknown, unknowns, known, knowns, seed, knowns, product, unknowns);
    return guard_numbers(run, guard_end(run, guard, is_ok(status)), product, unknowns);
}

bool call_output_derivatives(Run *run, const unsigned vr[], size_t n, const int order[], double value[]) {
    const Guard guard = guard_begin(run);
    const fmi3Status status = fmi3GetOutputDerivatives(run->c, vr, n, order, value, n);
    return guard_numbers(run, guard_end(run, guard, is_ok(status)), value, n);
}

/* ---- FMU states ---- */

bool raw_get_state(Run *run, void **state) {
    return is_ok(fmi3GetFMUState(run->c, state));
}

bool raw_free_state(Run *run, void **state) {
    return is_ok(fmi3FreeFMUState(run->c, state));
}

size_t raw_state_size(Run *run, void *state) {
    size_t size = 0;
    REQUIRE(run, is_ok(fmi3SerializedFMUStateSize(run->c, state, &size)));
    return size;
}

bool raw_serialize(Run *run, void *state, void *bytes, size_t size) {
    return is_ok(fmi3SerializeFMUState(run->c, state, bytes, size));
}

bool call_get_state(Run *run, void **state) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, raw_get_state(run, state));
}

bool call_set_state(Run *run, void *state) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3SetFMUState(run->c, state)));
}

bool call_free_state(Run *run, void **state) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, raw_free_state(run, state));
}

bool call_state_size(Run *run, void *state, size_t *size) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3SerializedFMUStateSize(run->c, state, size)));
}

bool call_serialize(Run *run, void *state, void *bytes, size_t size) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, raw_serialize(run, state, bytes, size));
}

bool call_deserialize(Run *run, const void *bytes, size_t size, void **state) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3DeserializeFMUState(run->c, bytes, size, state)));
}

/* ---- time ---- */

/* Time lands on t + h, to the last bit, or before it if the step returns early. */
bool call_step(Run *run, double t, double h) {
    fmi3Boolean event = false, terminate = false, early = false;
    double reached = 0.0;
    run->begin = t;
    const Guard guard = guard_begin(run);
    if (!guard_end(run, guard, is_ok(fmi3DoStep(run->c, t, h, false, &event, &terminate, &early, &reached))))
        return false;
    REQUIRE(run, !terminate);
    if (early) REQUIRE(run, reached >= t && reached < t + h);
    else REQUIRE(run, reached == t + h);
    run->time = reached;
    run->event = event;
    return true;
}

bool call_enter_events(Run *run) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3EnterEventMode(run->c)));
}

bool call_leave_events(Run *run) {
    const Guard guard = guard_begin(run);
    if (run->use == USE_MODEL_EXCHANGE) return guard_end(run, guard, is_ok(fmi3EnterContinuousTimeMode(run->c)));
    return guard_end(run, guard, is_ok(fmi3EnterStepMode(run->c)));
}

bool call_update_states(Run *run) {
    fmi3Boolean again, terminate, nominals, values, defined;
    double next;
    const Guard guard = guard_begin(run);
    return guard_end(run, guard,
                     is_ok(fmi3UpdateDiscreteStates(run->c, &again, &terminate, &nominals, &values, &defined, &next)));
}

bool call_complete_step(Run *run) {
    fmi3Boolean event, terminate;
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3CompletedIntegratorStep(run->c, false, &event, &terminate)));
}

bool call_set_time(Run *run, double time) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3SetTime(run->c, time)));
}

bool call_set_states(Run *run, const double x[], size_t n) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi3SetContinuousStates(run->c, x, n)));
}

bool call_get_states(Run *run, double x[], size_t n) {
    const Guard guard = guard_begin(run);
    return guard_numbers(run, guard_end(run, guard, is_ok(fmi3GetContinuousStates(run->c, x, n))), x, n);
}

bool call_get_derivatives(Run *run, double derivative[], size_t n) {
    const Guard guard = guard_begin(run);
    const fmi3Status status = fmi3GetContinuousStateDerivatives(run->c, derivative, n);
    return guard_numbers(run, guard_end(run, guard, is_ok(status)), derivative, n);
}

bool call_get_indicators(Run *run, double indicator[], size_t n) {
    const Guard guard = guard_begin(run);
    return guard_numbers(run, guard_end(run, guard, is_ok(fmi3GetEventIndicators(run->c, indicator, n))), indicator, n);
}

bool call_get_nominals(Run *run, double nominal[], size_t n) {
    const Guard guard = guard_begin(run);
    return guard_numbers(run, guard_end(run, guard, is_ok(fmi3GetNominalsOfContinuousStates(run->c, nominal, n))),
                         nominal, n);
}
#endif
