#include "operations.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "calls.h"
#include "guard.h"
#include "laws.h"
#include "plausible.h"

enum { MOST_CALLS = 120, MOST_STEPS = 30 }; /* of one input, so that no input takes long */

/* ---- begin and step ---- */

bool start(Run *run) {
    static const double tolerances[] = {1e-9, 1e-6, 1e-11, 1e-4};
    const unsigned choice = take_byte(&run->in);
    const double tolerance = tolerances[choice & 3], time = choice & 4 ? 1.5 : 0.0, stop = 1e3;
    const double *given = choice & 8 ? &tolerance : NULL;
    if (!call_enter_initialization(run, given, time, choice & 16 ? &stop : NULL)) return false;
    run->time = time;
    run->tolerance = given != NULL ? tolerance : 1e-9;
    if (!call_exit_initialization(run)) return false;
    if (run->use != USE_CO_SIMULATION && !(call_update_states(run) && call_leave_events(run))) return false;
    if (run->use != USE_MODEL_EXCHANGE) restart_account(run);
    return true;
}

/* The events that a step has ended on. */
static bool handle_events(Run *run) {
    run->event = false;
    return call_enter_events(run) && call_update_states(run) && call_leave_events(run);
}

/* s, the length of a step that may have returned early. The time is one double: the step is longer than the difference
 * of both times by up to a rounding of the time, and at large times this difference is 0. */
static double length_of_step(const Run *run, double before, double h) {
    return fmin(h, run->time - before + DBL_EPSILON * fabs(run->time));
}

static bool step(Run *run, double h) {
    const double before = run->time;
    if (!call_step(run, before, h)) return false;
    check_energies(run, length_of_step(run, before, h));
    return !run->event || run->use != USE_HYBRID || handle_events(run);
}

/* One step of Euler's method; at its end the events are handled if the input says so. */
static bool euler_step(Run *run, double h) {
    double x[CONTINUOUS_STATES + 1], rate[CONTINUOUS_STATES + 1], indicator[EVENT_INDICATORS];
    if (!call_get_states(run, x, CONTINUOUS_STATES) || !call_get_derivatives(run, rate, CONTINUOUS_STATES))
        return false;
    for (int i = 0; i < CONTINUOUS_STATES; i++) x[i] += h * rate[i];
    if (!call_set_time(run, run->time + h) || !call_set_states(run, x, CONTINUOUS_STATES) || !call_complete_step(run) ||
        !call_get_indicators(run, indicator, EVENT_INDICATORS))
        return false;
    run->time += h;
    return take_byte(&run->in) < 128 || handle_events(run);
}

static bool advance(Run *run, double h) {
    return run->use == USE_MODEL_EXCHANGE ? euler_step(run, h) : step(run, h);
}

/* A run from a restored state repeats itself bit for bit. */
static bool advance_twice(Run *run, double h) {
    void *start_state = NULL, *first = NULL, *second = NULL;
    const Run before = *run;
    if (!call_get_state(run, &start_state)) return false;
    const bool ok = advance(run, h);
    REQUIRE(run, raw_get_state(run, &first));
    REQUIRE(run, call_set_state(run, start_state));
    run->in = before.in, run->time = before.time, run->account = before.account, run->event = before.event;
    REQUIRE(run, advance(run, h) == ok);
    REQUIRE(run, raw_get_state(run, &second));
    REQUIRE(run, guard_same(run, first, second));
    REQUIRE(run, raw_free_state(run, &start_state) && raw_free_state(run, &first) && raw_free_state(run, &second));
    return ok;
}

bool drive(Run *run) {
    const unsigned choice = take_byte(&run->in);
    const double h = size_of(take_byte(&run->in), 1e-5, 0.1);
    if (choice & 1) set_plausible_inputs(run);
    return choice & 2 ? advance_twice(run, h) : advance(run, h);
}

/* ---- any calls ---- */

typedef struct {
    unsigned vr[MAX_REFERENCES];
    size_t n;
    bool absent; /* arrays are NULL */
} References;

static References take_references(Run *run) {
    References list = {.n = take_below(&run->in, 5)};
    list.absent = list.n == 4;
    for (size_t i = 0; i < list.n; i++) {
        const unsigned byte = take_byte(&run->in);
        list.vr[i] = byte < 250 ? byte : byte == 250 ? take_word(&run->in) : 0u - byte;
    }
    return list;
}

static const unsigned *array_of(const References *list) {
    return list->absent ? NULL : list->vr;
}

static void get_any(Run *run) {
    const References list = take_references(run);
    double real[MAX_REFERENCES], *values = list.absent ? NULL : real;
    int integer[MAX_REFERENCES];
    switch (take_below(&run->in, 4)) {
        case 0: call_get_reals(run, list.vr, list.n, values); break;
        case 1: call_get_integers(run, array_of(&list), list.n, integer); break;
        case 2: call_get_booleans(run, array_of(&list), list.n); break;
        default: call_get_texts(run, array_of(&list), list.n); break;
    }
}

static const char *take_text(Run *run) {
    static char text[1100];
    const unsigned kind = take_byte(&run->in);
    if (kind < 160) return take_file_name(run);
    if (kind == 160) return NULL;
    const size_t length = kind < 240 ? take_below(&run->in, 16) : 1020 + take_below(&run->in, 8);
    for (size_t i = 0; i < length; i++) text[i] = kind < 240 ? (char)take_byte(&run->in) : 'x';
    text[length] = '\0';
    return text;
}

static void set_any(Run *run) {
    const References list = take_references(run);
    double real[MAX_REFERENCES];
    int integer[MAX_REFERENCES];
    const char *text[MAX_REFERENCES];
    bool done = false;
    const unsigned type = take_below(&run->in, 4);
    for (size_t i = 0; i < list.n; i++) {
        if (type == 0) real[i] = take_any_number(&run->in);
        else if (type < 3) integer[i] = (int)take_byte(&run->in) - 8;
        else text[i] = take_text(run);
    }
    switch (type) {
        case 0: done = call_set_reals(run, array_of(&list), list.n, real); break;
        case 1: call_set_integers(run, list.vr, list.n, list.absent ? NULL : integer); break;
        case 2: call_set_booleans(run, array_of(&list), list.n, integer); break;
        default: call_set_texts(run, array_of(&list), list.n, text); break;
    }
    run->wild = run->wild || (done && list.n > 0);
}

static void step_by_any(Run *run) {
    const double t = take_byte(&run->in) < 200 ? run->time : take_any_number(&run->in);
    const double h = take_any_number(&run->in);
    if (call_step(run, t, h)) check_energies(run, length_of_step(run, t, h));
}

static void differentiate(Run *run) {
    const References unknown = take_references(run), known = take_references(run);
    double seed[MAX_REFERENCES], product[MAX_REFERENCES];
    int order[MAX_REFERENCES];
    for (size_t i = 0; i < known.n; i++) seed[i] = take_any_number(&run->in);
    for (size_t i = 0; i < unknown.n; i++) order[i] = 1 + (int)take_below(&run->in, 4) % 3;
    if (take_byte(&run->in) & 1)
        call_directional(run, array_of(&unknown), unknown.n, array_of(&known), known.n, seed, product);
    else call_output_derivatives(run, unknown.vr, unknown.n, unknown.absent ? NULL : order, product);
}

static void change_phase(Run *run) {
    switch (take_below(&run->in, 8)) {
        case 0: call_exit_initialization(run); break;
        case 1: call_terminate(run); break;
        case 2:
            if (!call_reset(run)) return;
            run->wild = false;
            run->account.known = false;
            break;
        case 3: call_enter_events(run); break;
        case 4: call_leave_events(run); break;
        case 5: call_update_states(run); break;
        case 6: call_complete_step(run); break;
        default: call_enter_initialization(run, NULL, 0.0, NULL); break;
    }
}

static void exchange_any(Run *run) {
    double x[MAX_REFERENCES + EVENT_INDICATORS];
    const size_t wrong = take_byte(&run->in) >= 230;
    const double time = take_any_number(&run->in);
    x[0] = take_any_number(&run->in), x[1] = take_any_number(&run->in), x[2] = 0.0;
    switch (take_below(&run->in, 6)) {
        case 0:
            if (call_set_time(run, time)) run->time = time;
            break;
        case 1:
            if (call_set_states(run, x, CONTINUOUS_STATES + wrong)) run->wild = true;
            break;
        case 2: call_get_states(run, x, CONTINUOUS_STATES + wrong); break;
        case 3: call_get_derivatives(run, wrong ? NULL : x, CONTINUOUS_STATES); break;
        case 4: call_get_indicators(run, x, EVENT_INDICATORS - wrong); break;
        default: call_get_nominals(run, x, CONTINUOUS_STATES + wrong); break;
    }
}

static void set_logging(Run *run) {
    static const char *const categories[] = {"logStatusError", "logAll", "logEvents", "no such", NULL};
    const unsigned choice = take_below(&run->in, 6), on = take_byte(&run->in) & 1;
    const bool concerns = choice == 0 || choice == 1 || choice == 5; /* errors */
    if (call_logging(run, on != 0, choice < 5, categories + choice % 5) && concerns) run->logs = on != 0;
}

/* ---- FMU states ---- */

static void save(Run *run, Slot *slot) {
    if (!call_get_state(run, &slot->state)) return;
    slot->time = run->time;
    slot->account = run->account;
}

static void restore(Run *run, const Slot *slot) {
    if (!call_set_state(run, slot->state)) return;
    run->time = slot->time;
    run->account = slot->account;
    run->wild = true; /* the saved run may have had any numbers */
}

/* Bytes of a saved state lead back to the same state; damaged ones are refused. */
static void serialize(Run *run, Slot *slot) {
    size_t size = 0;
    if (!call_state_size(run, slot->state, &size)) return;
    char *bytes = malloc(size);
    REQUIRE(run, bytes != NULL && call_serialize(run, slot->state, bytes, size));
    REQUIRE(run, !call_serialize(run, slot->state, bytes, size - 1));
    void *copy = NULL;
    REQUIRE(run, call_deserialize(run, bytes, size, &copy) && guard_same(run, slot->state, copy));
    bytes[take_word(&run->in) % size] ^= (char)(1 << (take_byte(&run->in) & 7));
    REQUIRE(run, !call_deserialize(run, bytes, size - (take_byte(&run->in) & 1), &copy));
    REQUIRE(run, call_free_state(run, &copy) && copy == NULL);
    free(bytes);
}

static void handle_state(Run *run) {
    Slot *slot = &run->slot[take_below(&run->in, SLOTS)];
    switch (take_below(&run->in, 5)) {
        case 0:
        case 1: save(run, slot); break;
        case 2: restore(run, slot); break;
        case 3: call_free_state(run, &slot->state); break;
        default: serialize(run, slot); break;
    }
}

/* ---- the input ---- */

/* Returns the number of steps that the call has made. */
static int make_call(Run *run) {
    const unsigned choice = take_below(&run->in, 32);
    if (choice < 6) return drive(run), 1;
    if (choice < 11) return set_plausible(run), 0;
    switch (choice) {
        case 11:
        case 12:
        case 13: start(run); break;
        case 14: set_groove_table(run, take_byte(&run->in) & 1, take_file_name(run)); break;
        case 15:
        case 16: get_any(run); break;
        case 17:
        case 18: set_any(run); break;
        case 19: step_by_any(run); return 1;
        case 20:
        case 21: differentiate(run); break;
        case 22: change_phase(run); break;
        case 23: exchange_any(run); break;
        case 24: set_logging(run); break;
        case 25:
        case 26: handle_state(run); break;
        case 27: check_values(run); break;
        default: call_special(run); break;
    }
    return 0;
}

void make_calls(Run *run) {
    int steps = 0;
    for (int calls = 0; calls < MOST_CALLS && steps < MOST_STEPS && bytes_left(&run->in); calls++)
        steps += make_call(run);
}

/* ---- one run ---- */

void run_begin(Run *run, Bytes in, Use use, unsigned options) {
    *run = (Run){.in = in, .options = options % OPTIONS, .logs = true, .tolerance = 1e-9};
    call_instantiate(run, use);
}

/* From the instantiated state, with the default parameters: the bytes after two steps. */
static void *default_run(Run *run, size_t *size) {
    void *state = NULL;
    run->in = (Bytes){NULL, NULL};
    REQUIRE(run, start(run));
    REQUIRE(run, advance(run, 0.01) && advance(run, 0.02));
    REQUIRE(run, raw_get_state(run, &state));
    void *bytes = guard_bytes_of(run, state, size);
    REQUIRE(run, raw_free_state(run, &state));
    return bytes;
}

static void free_states(Run *run) {
    for (int i = 0; i < SLOTS; i++) raw_free_state(run, &run->slot[i].state);
    raw_free_state(run, &run->before);
}

/* The bytes of a default run in a new instance: computed once for each use and its options. */
static const void *expected_run(Use use, unsigned options, size_t *size) {
    static void *bytes[USES][OPTIONS];
    static size_t sizes[USES][OPTIONS];
    if (bytes[use][options] == NULL) {
        Run run;
        run_begin(&run, (Bytes){NULL, NULL}, use, options);
        bytes[use][options] = default_run(&run, &sizes[use][options]);
        free_states(&run);
        call_free(&run);
    }
    *size = sizes[use][options];
    return bytes[use][options];
}

void run_end(Run *run) {
    size_t size, expected_size;
    REQUIRE(run, call_reset(run));
    run->wild = false;
    run->account.known = false;
    void *bytes = default_run(run, &size);
    const void *expected = expected_run(run->use, run->options, &expected_size);
    REQUIRE(run, size == expected_size && memcmp(bytes, expected, size) == 0);
    free(bytes);
    free_states(run);
    call_free(run);
}
