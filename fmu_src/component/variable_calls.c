/* Reading and setting variables, states and derivatives. */
#include <string.h>

#include "component/component.h"

/* ---- variables by type ---- */

#define VARIABLES(name, Type, suffix)                                                                                  \
    EXPORT("get-" name) ListResult *get_##suffix(const Handle *me, const fmi3ValueReference *vr, size_t n) {           \
        fmi3##Type *const values = hold(n * sizeof *values);                                                           \
        return list_result(fmi3Get##Type(me->fmu, vr, n, values, n), values, n);                                       \
    }                                                                                                                  \
    EXPORT("set-" name)                                                                                                \
    fmi3Status set_##suffix(const Handle *me, const fmi3ValueReference *vr, size_t n, const fmi3##Type *values,        \
                            size_t value_count) {                                                                      \
        return fmi3Set##Type(me->fmu, vr, n, values, value_count);                                                     \
    }

VARIABLES("float32", Float32, float32)
VARIABLES("float64", Float64, float64)
VARIABLES("int8", Int8, int8)
VARIABLES("uint8", UInt8, uint8)
VARIABLES("int16", Int16, int16)
VARIABLES("uint16", UInt16, uint16)
VARIABLES("int32", Int32, int32)
VARIABLES("uint32", UInt32, uint32)
VARIABLES("int64", Int64, int64)
VARIABLES("uint64", UInt64, uint64)
VARIABLES("boolean", Boolean, boolean)

EXPORT("get-string") ListResult *get_string(const Handle *me, const fmi3ValueReference *vr, size_t n) {
    fmi3String *const values = hold(n * sizeof *values);
    Text *const texts = hold(n * sizeof *texts);
    const fmi3Status status = fmi3GetString(me->fmu, vr, n, values, n);
    for (size_t i = 0; i < n && !is_refused(status); i++) texts[i] = (Text){values[i], strlen(values[i])};
    return list_result(status, texts, n);
}

EXPORT("set-string")
fmi3Status set_string(const Handle *me, const fmi3ValueReference *vr, size_t n, const Text *values,
                      size_t value_count) {
    return fmi3SetString(me->fmu, vr, n, hold_texts(values, value_count), value_count);
}

/* The FMU has no variables of the types Binary and Clock: every list of variables but the empty one is refused. */
EXPORT("get-binary") ListResult *get_binary(const Handle *me, const fmi3ValueReference *vr, size_t n) {
    return list_result(fmi3GetBinary(me->fmu, vr, n, NULL, NULL, n), NULL, 0);
}

EXPORT("set-binary")
fmi3Status set_binary(const Handle *me, const fmi3ValueReference *vr, size_t n, const Text *values,
                      size_t value_count) {
    (void)values;
    return fmi3SetBinary(me->fmu, vr, n, NULL, NULL, value_count);
}

EXPORT("get-clock") ListResult *get_clock(const Handle *me, const fmi3ValueReference *vr, size_t n) {
    return list_result(fmi3GetClock(me->fmu, vr, n, NULL), NULL, 0);
}

EXPORT("set-clock")
fmi3Status set_clock(const Handle *me, const fmi3ValueReference *vr, size_t n, const bool *values, size_t value_count) {
    (void)value_count;
    return fmi3SetClock(me->fmu, vr, n, values);
}

EXPORT("get-interval-decimal") ListResult *get_interval(const Handle *me, const fmi3ValueReference *vr, size_t n) {
    return list_result(fmi3GetIntervalDecimal(me->fmu, vr, n, NULL, NULL), NULL, 0);
}

EXPORT("get-interval-fraction")
ListResult *get_interval_fraction(const Handle *me, const fmi3ValueReference *vr, size_t n) {
    return list_result(fmi3GetIntervalFraction(me->fmu, vr, n, NULL, NULL, NULL), NULL, 0);
}

EXPORT("get-shift-decimal") ListResult *get_shift(const Handle *me, const fmi3ValueReference *vr, size_t n) {
    return list_result(fmi3GetShiftDecimal(me->fmu, vr, n, NULL), NULL, 0);
}

EXPORT("get-shift-fraction") ListResult *get_shift_fraction(const Handle *me, const fmi3ValueReference *vr, size_t n) {
    return list_result(fmi3GetShiftFraction(me->fmu, vr, n, NULL, NULL), NULL, 0);
}

EXPORT("set-interval-decimal")
fmi3Status set_interval(const Handle *me, const fmi3ValueReference *vr, size_t n, const double *values, size_t count) {
    (void)count;
    return fmi3SetIntervalDecimal(me->fmu, vr, n, values);
}

EXPORT("set-interval-fraction")
fmi3Status set_interval_fraction(const Handle *me, const fmi3ValueReference *vr, size_t n, const void *values,
                                 size_t count) {
    (void)values, (void)count;
    return fmi3SetIntervalFraction(me->fmu, vr, n, NULL, NULL);
}

EXPORT("set-shift-decimal")
fmi3Status set_shift(const Handle *me, const fmi3ValueReference *vr, size_t n, const double *values, size_t count) {
    (void)count;
    return fmi3SetShiftDecimal(me->fmu, vr, n, values);
}

EXPORT("set-shift-fraction")
fmi3Status set_shift_fraction(const Handle *me, const fmi3ValueReference *vr, size_t n, const void *values,
                              size_t count) {
    (void)values, (void)count;
    return fmi3SetShiftFraction(me->fmu, vr, n, NULL, NULL);
}

/* ---- FMU states ---- */

EXPORT("get-fmu-state") ListResult *get_fmu_state(const Handle *me) {
    fmi3FMUState state = NULL;
    fmi3Byte *bytes = NULL;
    size_t size = 0;
    fmi3Status status = fmi3GetFMUState(me->fmu, &state);
    if (!is_refused(status)) status = fmi3SerializedFMUStateSize(me->fmu, state, &size);
    if (!is_refused(status)) {
        bytes = hold(size);
        status = fmi3SerializeFMUState(me->fmu, state, bytes, size);
    }
    fmi3FreeFMUState(me->fmu, &state);
    return list_result(status, bytes, size);
}

EXPORT("set-fmu-state") fmi3Status set_fmu_state(const Handle *me, const fmi3Byte *bytes, size_t size) {
    fmi3FMUState state = NULL;
    fmi3Status status = fmi3DeserializeFMUState(me->fmu, bytes, size, &state);
    if (!is_refused(status)) status = fmi3SetFMUState(me->fmu, state);
    fmi3FreeFMUState(me->fmu, &state);
    return status;
}

/* ---- dependencies ---- */

/* A number, or the status of the refused call. */
typedef struct {
    uint8_t refused;
    union {
        uint64_t number;
        uint8_t status;
    };
} CountResult;

static CountResult *count_result(fmi3Status status, size_t number) {
    static CountResult result;
    result = (CountResult){.refused = is_refused(status)};
    if (result.refused) result.status = (uint8_t)status;
    else result.number = number;
    return &result;
}

EXPORT("get-number-of-variable-dependencies")
CountResult *get_number_of_dependencies(const Handle *me, fmi3ValueReference dependent) {
    size_t n = 0;
    return count_result(fmi3GetNumberOfVariableDependencies(me->fmu, dependent, &n), n);
}

/* The draft's kinds begin with `dependent`; FMI's begin with `independent`, which the draft does not have. */
typedef enum { KIND_DEPENDENT, KIND_CONSTANT, KIND_FIXED, KIND_TUNABLE, KIND_DISCRETE } Kind;

static Kind kind_of(fmi3DependencyKind kind) {
    switch (kind) {
        case fmi3Constant: return KIND_CONSTANT;
        case fmi3Fixed: return KIND_FIXED;
        case fmi3Tunable: return KIND_TUNABLE;
        case fmi3Discrete: return KIND_DISCRETE;
        default: return KIND_DEPENDENT;
    }
}

typedef struct {
    fmi3ValueReference dependent;
    uint32_t dependent_element;
    fmi3ValueReference independent;
    uint32_t independent_element;
    uint8_t kind;
} VariableDependency;

EXPORT("get-variable-dependencies") ListResult *get_dependencies(const Handle *me, fmi3ValueReference dependent) {
    size_t n = 0;
    fmi3Status status = fmi3GetNumberOfVariableDependencies(me->fmu, dependent, &n);
    if (is_refused(status)) return list_result(status, NULL, 0);
    size_t *const elements = hold(n * sizeof *elements), *const others = hold(n * sizeof *others);
    fmi3ValueReference *const independents = hold(n * sizeof *independents);
    fmi3DependencyKind *const kinds = hold(n * sizeof *kinds);
    VariableDependency *const rows = hold(n * sizeof *rows);
    status = fmi3GetVariableDependencies(me->fmu, dependent, elements, independents, others, kinds, n);
    for (size_t i = 0; i < n && !is_refused(status); i++)
        rows[i] = (VariableDependency){dependent, (uint32_t)elements[i], independents[i], (uint32_t)others[i],
                                       (uint8_t)kind_of(kinds[i])};
    return list_result(status, rows, n);
}

/* ---- derivatives ---- */

EXPORT("get-directional-derivative")
ListResult *get_directional_derivative(const Handle *me, const fmi3ValueReference *unknowns, size_t unknown_count,
                                       const fmi3ValueReference *knowns, size_t known_count, const double *seed,
                                       size_t seed_count) {
    double *const values = hold(unknown_count * sizeof *values);
    return list_result(fmi3GetDirectionalDerivative(me->fmu, unknowns, unknown_count, knowns, known_count, seed,
                                                    seed_count, values, unknown_count),
                       values, unknown_count);
}

EXPORT("get-adjoint-derivative")
ListResult *get_adjoint_derivative(const Handle *me, const fmi3ValueReference *unknowns, size_t unknown_count,
                                   const fmi3ValueReference *knowns, size_t known_count, const double *seed,
                                   size_t seed_count) {
    double *const values = hold(known_count * sizeof *values);
    return list_result(fmi3GetAdjointDerivative(me->fmu, unknowns, unknown_count, knowns, known_count, seed, seed_count,
                                                values, known_count),
                       values, known_count);
}

EXPORT("get-output-derivatives")
ListResult *get_output_derivatives(const Handle *me, const Request *requests, size_t n) {
    fmi3ValueReference *const vr = hold(n * sizeof *vr);
    fmi3Int32 *const orders = hold(n * sizeof *orders);
    double *const values = hold(n * sizeof *values);
    for (size_t i = 0; i < n; i++) {
        vr[i] = requests[i].reference;
        orders[i] = requests[i].order > INT32_MAX ? INT32_MAX : (fmi3Int32)requests[i].order;
    }
    return list_result(fmi3GetOutputDerivatives(me->fmu, vr, n, orders, values, n), values, n);
}

/* A function of the draft that FMI 3.0 does not have. */
EXPORT("set-input-derivatives")
fmi3Status set_input_derivatives(const Handle *me, const Request *requests, size_t n, const double *values,
                                 size_t value_count) {
    (void)requests, (void)n, (void)values, (void)value_count;
    log_message(me, fmi3Error, "logStatusError",
                "set-input-derivatives: FMI 3.0 has no derivatives of inputs: allowed is not to call this function");
    return fmi3Error;
}

/* ---- continuous states ---- */

#define NUMBER(name, function, fmi_function)                                                                           \
    EXPORT(name) CountResult *function(const Handle *me) {                                                             \
        size_t n = 0;                                                                                                  \
        return count_result(fmi_function(me->fmu, &n), n);                                                             \
    }

NUMBER("get-number-of-event-indicators", get_number_of_event_indicators, fmi3GetNumberOfEventIndicators)
NUMBER("get-number-of-continuous-states", get_number_of_continuous_states, fmi3GetNumberOfContinuousStates)

#define VECTOR(name, function, fmi_function, fmi_number)                                                               \
    EXPORT(name) ListResult *function(const Handle *me) {                                                              \
        size_t n = 0;                                                                                                  \
        fmi3Status status = fmi_number(me->fmu, &n);                                                                   \
        double *const values = hold(n * sizeof *values);                                                               \
        if (!is_refused(status)) status = fmi_function(me->fmu, values, n);                                            \
        return list_result(status, values, n);                                                                         \
    }

VECTOR("get-continuous-states", get_states, fmi3GetContinuousStates, fmi3GetNumberOfContinuousStates)
VECTOR("get-continuous-state-derivatives", get_state_derivatives, fmi3GetContinuousStateDerivatives,
       fmi3GetNumberOfContinuousStates)
VECTOR("get-nominals-of-continuous-states", get_nominals, fmi3GetNominalsOfContinuousStates,
       fmi3GetNumberOfContinuousStates)
VECTOR("get-event-indicators", get_event_indicators, fmi3GetEventIndicators, fmi3GetNumberOfEventIndicators)

EXPORT("set-continuous-states") fmi3Status set_states(const Handle *me, const double *values, size_t n) {
    return fmi3SetContinuousStates(me->fmu, values, n);
}
