/* What FMI 2.0 does in its own way, and what it alone has. */
#if FMI_VERSION == 2
#include "calls.h"
#include "fmi.h"
#include "guard.h"

static void log_message(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                        fmi2String category, fmi2String message, ...) {
    (void)instance, (void)status, (void)category;
    Run *run = environment;
    snprintf(run->message, sizeof run->message, "%s", message);
    run->messages++;
}

void call_instantiate(Run *run, Use use) {
    static const char *const scheme[] = {"file://%s", "file:%s/", "file://localhost%s"};
    char location[1024];
    snprintf(location, sizeof location, scheme[run->options % 3], directory());
    const fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, run};
    run->use = use == USE_MODEL_EXCHANGE ? USE_MODEL_EXCHANGE : USE_CO_SIMULATION;
    run->c = fmi2Instantiate("fuzz", use == USE_MODEL_EXCHANGE ? fmi2ModelExchange : fmi2CoSimulation, MODEL_GUID,
                             location, &callbacks, fmi2False, fmi2True);
    REQUIRE(run, run->c != NULL);
}

static bool setup(Run *run, const double *tolerance, double start, const double *stop) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard,
                     is_ok(fmi2SetupExperiment(run->c, tolerance != NULL, tolerance != NULL ? *tolerance : 0.0, start,
                                               stop != NULL, stop != NULL ? *stop : 0.0)));
}

bool call_enter_initialization(Run *run, const double *tolerance, double start, const double *stop) {
    if (!setup(run, tolerance, start, stop)) return false;
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi2EnterInitializationMode(run->c)));
}

/* Time lands on t + h, to the last bit. */
static void check_time(Run *run, double expected) {
    double time = 0.0;
    REQUIRE(run, is_ok(fmi2GetRealStatus(run->c, fmi2LastSuccessfulTime, &time)));
    REQUIRE(run, time == expected);
}

bool call_step(Run *run, double t, double h) {
    const Guard guard = guard_begin(run);
    if (!guard_end(run, guard, is_ok(fmi2DoStep(run->c, t, h, fmi2False)))) return false;
    check_time(run, t + h);
    run->time = t + h;
    return true;
}

bool call_leave_events(Run *run) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi2EnterContinuousTimeMode(run->c)));
}

bool call_update_states(Run *run) {
    fmi2EventInfo info;
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(fmi2NewDiscreteStates(run->c, &info)));
}

/* ---- what only FMI 2.0 has ---- */

static bool set_input_derivatives(Run *run) {
    unsigned vr[MAX_REFERENCES];
    int order[MAX_REFERENCES];
    double value[MAX_REFERENCES];
    const size_t n = take_below(&run->in, 4);
    const bool plausible = take_byte(&run->in) < 200;
    for (size_t i = 0; i < n; i++) {
        vr[i] = plausible ? take_below(&run->in, 4) : take_byte(&run->in);
        order[i] = plausible ? 1 + (int)take_below(&run->in, 3) : (int)take_byte(&run->in) - 100;
        value[i] = plausible ? 10.0 * ((int)take_byte(&run->in) - 128) : take_any_number(&run->in);
    }
    const Guard guard = guard_begin(run);
    const bool ok = guard_end(run, guard, is_ok(fmi2SetRealInputDerivatives(run->c, vr, n, order, value)));
    if (ok && !plausible) run->wild = true;
    return ok;
}

static fmi2Status ask_status(Run *run, unsigned question) {
    const fmi2StatusKind kind = (fmi2StatusKind)take_below(&run->in, 5);
    fmi2Status status;
    fmi2Real real;
    fmi2Integer integer;
    fmi2Boolean boolean;
    fmi2String text;
    switch (question) {
        case 0: return fmi2GetStatus(run->c, kind, &status);
        case 1: return fmi2GetRealStatus(run->c, kind, &real);
        case 2: return fmi2GetIntegerStatus(run->c, kind, &integer);
        case 3: return fmi2GetBooleanStatus(run->c, kind, &boolean);
        case 4: return fmi2GetStringStatus(run->c, kind, &text);
        default: return fmi2CancelStep(run->c);
    }
}

/* The two calls of initialization apart, with any numbers. */
static void begin_somehow(Run *run) {
    const double tolerance = take_any_number(&run->in), start = take_any_number(&run->in);
    const double stop = take_any_number(&run->in);
    const unsigned given = take_below(&run->in, 4);
    if (setup(run, given & 1 ? &tolerance : NULL, start, given & 2 ? &stop : NULL)) {
        run->time = start;
        run->tolerance = 1.0; /* unknown: no check of energies */
        run->wild = true;
    }
    if (take_byte(&run->in) < 128) return;
    const Guard guard = guard_begin(run);
    guard_end(run, guard, is_ok(fmi2EnterInitializationMode(run->c)));
}

void call_special(Run *run) {
    const unsigned choice = take_below(&run->in, 16);
    if (choice < 8) {
        set_input_derivatives(run);
    } else if (choice < 10) {
        begin_somehow(run);
    } else {
        const Guard guard = guard_begin(run);
        guard_end(run, guard, is_ok(ask_status(run, choice - 10)));
    }
}
#endif
