/* The functions of calls.h that differ between FMI 2.0 and FMI 3.0 by names and counts alone. */
#include "calls.h"

#include <string.h>

#include "fmi.h"
#include "guard.h"

/* ---- life ---- */

void call_free(Run *run) {
    FMI(FreeInstance)(run->c);
}

bool call_exit_initialization(Run *run) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI(ExitInitializationMode)(run->c)));
}

bool call_terminate(Run *run) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI(Terminate)(run->c)));
}

bool call_reset(Run *run) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI(Reset)(run->c)));
}

bool call_logging(Run *run, bool on, size_t n, const char *const categories[]) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI(SetDebugLogging)(run->c, on, n, (const FMI(String) *)categories)));
}

/* ---- variables ---- */

bool call_get_reals(Run *run, const unsigned vr[], size_t n, double value[]) {
    const Guard guard = guard_begin(run);
    return guard_numbers(
        run, guard_end(run, guard, is_ok(FMI_2_3(GetReal, GetFloat64)(run->c, vr, n, value VALUES(n)))), value, n);
}

bool call_get_integers(Run *run, const unsigned vr[], size_t n, int value[]) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI_2_3(GetInteger, GetInt32)(run->c, vr, n, value VALUES(n))));
}

bool call_get_booleans(Run *run, const unsigned vr[], size_t n) {
    FMI(Boolean) value[MAX_REFERENCES];
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI(GetBoolean)(run->c, vr, n, value VALUES(n))));
}

bool call_get_texts(Run *run, const unsigned vr[], size_t n) {
    FMI(String) value[MAX_REFERENCES];
    const Guard guard = guard_begin(run);
    const bool ok = guard_end(run, guard, is_ok(FMI(GetString)(run->c, vr, n, value VALUES(n))));
    for (size_t i = 0; ok && i < n; i++) REQUIRE(run, strlen(value[i]) < 1024);
    return ok;
}

bool call_set_reals(Run *run, const unsigned vr[], size_t n, const double value[]) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI_2_3(SetReal, SetFloat64)(run->c, vr, n, value VALUES(n))));
}

bool call_set_integers(Run *run, const unsigned vr[], size_t n, const int value[]) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI_2_3(SetInteger, SetInt32)(run->c, vr, n, value VALUES(n))));
}

bool call_set_booleans(Run *run, const unsigned vr[], size_t n, const int value[]) {
    FMI(Boolean) boolean[MAX_REFERENCES];
    for (size_t i = 0; i < n && value != NULL; i++) boolean[i] = (FMI(Boolean))value[i];
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI(SetBoolean)(run->c, vr, n, value != NULL ? boolean : NULL VALUES(n))));
}

bool call_set_texts(Run *run, const unsigned vr[], size_t n, const char *const value[]) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI(SetString)(run->c, vr, n, (const FMI(String) *)value VALUES(n))));
}

bool call_directional(Run *run, const unsigned unknown[], size_t unknowns, const unsigned known[], size_t knowns,
                      const double seed[], double product[]) {
    const Guard guard = guard_begin(run);
    const FMI(Status) status = FMI(GetDirectionalDerivative)(run->c, unknown, unknowns, known, knowns,
                                                             seed VALUES(knowns), product VALUES(unknowns));
    return guard_numbers(run, guard_end(run, guard, is_ok(status)), product, unknowns);
}

bool call_output_derivatives(Run *run, const unsigned vr[], size_t n, const int order[], double value[]) {
    const Guard guard = guard_begin(run);
    const FMI(Status) status =
        FMI_2_3(GetRealOutputDerivatives, GetOutputDerivatives)(run->c, vr, n, order, value VALUES(n));
    return guard_numbers(run, guard_end(run, guard, is_ok(status)), value, n);
}

/* ---- FMU states ---- */

bool raw_get_state(Run *run, void **state) {
    return is_ok(FMI_2_3(GetFMUstate, GetFMUState)(run->c, state));
}

bool raw_free_state(Run *run, void **state) {
    return is_ok(FMI_2_3(FreeFMUstate, FreeFMUState)(run->c, state));
}

size_t raw_state_size(Run *run, void *state) {
    size_t size = 0;
    REQUIRE(run, is_ok(FMI_2_3(SerializedFMUstateSize, SerializedFMUStateSize)(run->c, state, &size)));
    return size;
}

bool raw_serialize(Run *run, void *state, void *bytes, size_t size) {
    return is_ok(FMI_2_3(SerializeFMUstate, SerializeFMUState)(run->c, state, bytes, size));
}

bool call_get_state(Run *run, void **state) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, raw_get_state(run, state));
}

bool call_set_state(Run *run, void *state) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI_2_3(SetFMUstate, SetFMUState)(run->c, state)));
}

bool call_free_state(Run *run, void **state) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, raw_free_state(run, state));
}

bool call_state_size(Run *run, void *state, size_t *size) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI_2_3(SerializedFMUstateSize, SerializedFMUStateSize)(run->c, state, size)));
}

bool call_serialize(Run *run, void *state, void *bytes, size_t size) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, raw_serialize(run, state, bytes, size));
}

bool call_deserialize(Run *run, const void *bytes, size_t size, void **state) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI_2_3(DeSerializeFMUstate, DeserializeFMUState)(run->c, bytes, size, state)));
}

/* ---- time ---- */

bool call_enter_events(Run *run) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI(EnterEventMode)(run->c)));
}

bool call_complete_step(Run *run) {
    FMI(Boolean) event, terminate;
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI(CompletedIntegratorStep)(run->c, false, &event, &terminate)));
}

bool call_set_time(Run *run, double time) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI(SetTime)(run->c, time)));
}

bool call_set_states(Run *run, const double x[], size_t n) {
    const Guard guard = guard_begin(run);
    return guard_end(run, guard, is_ok(FMI(SetContinuousStates)(run->c, x, n)));
}

bool call_get_states(Run *run, double x[], size_t n) {
    const Guard guard = guard_begin(run);
    return guard_numbers(run, guard_end(run, guard, is_ok(FMI(GetContinuousStates)(run->c, x, n))), x, n);
}

bool call_get_derivatives(Run *run, double derivative[], size_t n) {
    const Guard guard = guard_begin(run);
    return guard_numbers(
        run,
        guard_end(run, guard, is_ok(FMI_2_3(GetDerivatives, GetContinuousStateDerivatives)(run->c, derivative, n))),
        derivative, n);
}

bool call_get_indicators(Run *run, double indicator[], size_t n) {
    const Guard guard = guard_begin(run);
    return guard_numbers(run, guard_end(run, guard, is_ok(FMI(GetEventIndicators)(run->c, indicator, n))), indicator,
                         n);
}

bool call_get_nominals(Run *run, double nominal[], size_t n) {
    const Guard guard = guard_begin(run);
    return guard_numbers(run, guard_end(run, guard, is_ok(FMI(GetNominalsOfContinuousStates)(run->c, nominal, n))),
                         nominal, n);
}
