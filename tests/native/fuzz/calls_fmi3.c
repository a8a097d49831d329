/* What FMI 3.0 does in its own way, and what it alone has: the intermediate update of a step, adjoint derivatives,
 * dependencies, refused functions. */
#if FMI_VERSION == 3
#include "calls.h"
#include "fmi.h"
#include "guard.h"

/* ---- the master's part in a step ---- */

/* Calls that a master must not make inside a step. */
static void call_out_of_order(Run *run) {
    void *state = NULL;
    switch (take_below(&run->in, 6)) {
        case 0: REQUIRE(run, !call_step(run, run->time, 0.01)); break;
        case 1: REQUIRE(run, !call_reset(run)); break;
        case 2: REQUIRE(run, !call_get_state(run, &state)); break;
        case 3: REQUIRE(run, !call_terminate(run)); break;
        case 4: REQUIRE(run, !call_enter_events(run)); break;
        default: REQUIRE(run, !call_update_states(run)); break;
    }
}

static void intermediate_update(fmi3InstanceEnvironment environment, fmi3Float64 time, fmi3Boolean set_requested,
                                fmi3Boolean get_allowed, fmi3Boolean finished, fmi3Boolean can_return_early,
                                fmi3Boolean *return_requested, fmi3Float64 *return_time) {
    (void)finished;
    Run *run = environment;
    double value[1] = {((int)take_byte(&run->in) - 128) / 8.0};
    const unsigned vr = take_below(&run->in, 6), choice = take_byte(&run->in);
    run->inside = true;
    REQUIRE(run, run->wild || time >= run->begin);
    if (set_requested) call_set_reals(run, &vr, 1, value);
    if (get_allowed) call_get_reals(run, &vr, 1, value);
    if (choice >= 200) call_out_of_order(run);
    run->inside = false;
    *return_requested = choice % 4 == 0;
    *return_time = time + choice * 1e-4;
    if (!can_return_early && choice % 8 == 0) *return_time = take_any_number(&run->in);
}

/* ---- life and time ---- */

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

bool call_enter_initialization(Run *run, const double *tolerance, double start, const double *stop) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard,
                     is_ok(fmi3EnterInitializationMode(run->c, tolerance != NULL, tolerance != NULL ? *tolerance : 0.0,
                                                       start, stop != NULL, stop != NULL ? *stop : 0.0)));
}

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

/* ---- derivatives and dependencies ---- */

static bool adjoint(Run *run) {
    fmi3ValueReference unknown[MAX_REFERENCES], known[MAX_REFERENCES];
    double seed[MAX_REFERENCES], product[MAX_REFERENCES];
    const size_t unknowns = take_below(&run->in, 4), knowns = take_below(&run->in, 4);
    const size_t missing = take_byte(&run->in) >= 240;
    for (size_t i = 0; i < unknowns; i++) unknown[i] = take_byte(&run->in), seed[i] = take_any_number(&run->in);
    for (size_t i = 0; i < knowns; i++) known[i] = take_byte(&run->in);
    const Guard guard = guard_begin(run);
    const fmi3Status status =
        fmi3GetAdjointDerivative(run->c, unknown, unknowns, known, knowns, seed, unknowns + missing, product, knowns);
    return guard_numbers(run, guard_end(run, guard, is_ok(status)), product, knowns);
}

static bool dependencies(Run *run) {
    enum { MOST = 256 };
    static size_t dependent[MOST], independent[MOST];
    static fmi3ValueReference known[MOST];
    static fmi3DependencyKind kind[MOST];
    const fmi3ValueReference unknown = take_byte(&run->in);
    const size_t more = take_byte(&run->in) >= 240;
    size_t n = 0;
    Guard guard = guard_begin(run);
    if (!guard_end(run, guard, is_ok(fmi3GetNumberOfVariableDependencies(run->c, unknown, &n)))) return false;
    REQUIRE(run, n < MOST);
    guard = guard_begin(run);
    const bool ok = guard_end(
        run, guard, is_ok(fmi3GetVariableDependencies(run->c, unknown, dependent, known, independent, kind, n + more)));
    REQUIRE(run, ok == (more == 0));
    for (size_t i = 0; ok && i < n; i++) REQUIRE(run, has_variable(known[i]));
    return ok;
}

static bool counts(Run *run) {
    size_t states = 99, indicators = 99;
    const Guard guard = guard_begin(run);
    const bool ok = is_ok(fmi3GetNumberOfContinuousStates(run->c, &states)) &&
                    is_ok(fmi3GetNumberOfEventIndicators(run->c, &indicators));
    REQUIRE(run, !ok || (states == CONTINUOUS_STATES && indicators == EVENT_INDICATORS));
    return guard_end(run, guard, ok);
}

/* ---- functions without an answer ---- */

static fmi3Status other_type(Run *run, unsigned choice, size_t n) {
    const fmi3ValueReference vr[MAX_REFERENCES] = {take_byte(&run->in)};
    union {
        fmi3Float32 f32;
        fmi3Int8 i8;
        fmi3UInt8 u8;
        fmi3Int16 i16;
        fmi3UInt16 u16;
        fmi3UInt32 u32;
        fmi3Int64 i64;
        fmi3UInt64 u64;
        fmi3Clock clock;
    } value[MAX_REFERENCES] = {{0}};
    size_t size[MAX_REFERENCES] = {0};
    fmi3Binary binary[MAX_REFERENCES] = {NULL};
    switch (choice) {
        case 0: return fmi3GetFloat32(run->c, vr, n, &value->f32, n);
        case 1: return fmi3SetFloat32(run->c, vr, n, &value->f32, n);
        case 2: return fmi3GetInt8(run->c, vr, n, &value->i8, n);
        case 3: return fmi3SetInt8(run->c, vr, n, &value->i8, n);
        case 4: return fmi3GetUInt8(run->c, vr, n, &value->u8, n);
        case 5: return fmi3SetUInt8(run->c, vr, n, &value->u8, n);
        case 6: return fmi3GetInt16(run->c, vr, n, &value->i16, n);
        case 7: return fmi3SetInt16(run->c, vr, n, &value->i16, n);
        case 8: return fmi3GetUInt16(run->c, vr, n, &value->u16, n);
        case 9: return fmi3SetUInt16(run->c, vr, n, &value->u16, n);
        case 10: return fmi3GetUInt32(run->c, vr, n, &value->u32, n);
        case 11: return fmi3SetUInt32(run->c, vr, n, &value->u32, n);
        case 12: return fmi3GetInt64(run->c, vr, n, &value->i64, n);
        case 13: return fmi3SetInt64(run->c, vr, n, &value->i64, n);
        case 14: return fmi3GetUInt64(run->c, vr, n, &value->u64, n);
        case 15: return fmi3SetUInt64(run->c, vr, n, &value->u64, n);
        case 16: return fmi3GetBinary(run->c, vr, n, size, binary, n);
        case 17: return fmi3SetBinary(run->c, vr, n, size, binary, n);
        case 18: return fmi3GetClock(run->c, vr, n, &value->clock);
        default: return fmi3SetClock(run->c, vr, n, &value->clock);
    }
}

static fmi3Status of_clocks(Run *run, unsigned choice, size_t n) {
    const fmi3ValueReference vr[MAX_REFERENCES] = {take_byte(&run->in)};
    double interval[MAX_REFERENCES] = {0.0};
    fmi3UInt64 counter[MAX_REFERENCES] = {0}, resolution[MAX_REFERENCES] = {0};
    fmi3IntervalQualifier qualifier[MAX_REFERENCES];
    switch (choice) {
        case 0: return fmi3GetIntervalDecimal(run->c, vr, n, interval, qualifier);
        case 1: return fmi3GetIntervalFraction(run->c, vr, n, counter, resolution, qualifier);
        case 2: return fmi3GetShiftDecimal(run->c, vr, n, interval);
        case 3: return fmi3GetShiftFraction(run->c, vr, n, counter, resolution);
        case 4: return fmi3SetIntervalDecimal(run->c, vr, n, interval);
        case 5: return fmi3SetIntervalFraction(run->c, vr, n, counter, resolution);
        case 6: return fmi3SetShiftDecimal(run->c, vr, n, interval);
        case 7: return fmi3SetShiftFraction(run->c, vr, n, counter, resolution);
        case 8: return fmi3ActivateModelPartition(run->c, vr[0], run->time);
        case 9: return fmi3EnterConfigurationMode(run->c);
        case 10: return fmi3ExitConfigurationMode(run->c);
        default: return fmi3EvaluateDiscreteStates(run->c);
    }
}

static bool unsupported(Run *run) {
    const unsigned choice = take_below(&run->in, 32);
    const size_t n = take_byte(&run->in) < 200;
    const Guard guard = guard_begin(run);
    const bool ok =
        guard_end(run, guard, is_ok(choice < 20 ? other_type(run, choice, n) : of_clocks(run, choice - 20, n)));
    if (n > 0) REQUIRE(run, !ok);
    return ok;
}

/* As many values as variables: another number is refused. */
static bool wrong_count(Run *run) {
    const fmi3ValueReference vr[2] = {take_below(&run->in, 8), 0};
    double value[2] = {0.0, 0.0};
    const Guard guard = guard_begin(run);
    const bool ok = guard_end(run, guard, is_ok(fmi3GetFloat64(run->c, vr, 1, value, 2)));
    REQUIRE(run, !ok);
    return ok;
}

/* Any numbers to begin with. */
static bool begin_somehow(Run *run) {
    const double tolerance = take_any_number(&run->in), start = take_any_number(&run->in);
    const double stop = take_any_number(&run->in);
    const unsigned given = take_below(&run->in, 4);
    if (!call_enter_initialization(run, given & 1 ? &tolerance : NULL, start, given & 2 ? &stop : NULL)) return false;
    run->time = start;
    run->wild = true;
    return true;
}

void call_special(Run *run) {
    switch (take_below(&run->in, 8)) {
        case 0:
        case 1:
        case 2: adjoint(run); break;
        case 3:
        case 4: dependencies(run); break;
        case 5: counts(run); break;
        case 6: begin_somehow(run); break;
        default:
            if (take_byte(&run->in) < 240) unsupported(run);
            else wrong_count(run);
            break;
    }
}
#endif
