#include "fmi/access.h"

#include <math.h>
#include <string.h>

#include "platform/arithmetic.h"
#include "platform/attributes.h"

COLD static void refuse_arrays(const Instance *instance, const char *function, size_t n,
                               const ValueReference references[], const void *values) {
    if (instance_has_array(instance, function, n, references, "vr"))
        instance_has_array(instance, function, n, values, "value");
}

bool access_has_arrays(const Instance *instance, const char *function, size_t n, const ValueReference references[],
                       const void *values) {
    if (n == 0 || (references != NULL && values != NULL)) return true;
    refuse_arrays(instance, function, n, references, values);
    return false;
}

COLD static void refuse_reference(const Instance *instance, const char *function, ValueReference reference, Type type) {
    const Variable *variable = variable_find(reference);
    if (variable == NULL)
        instance_refuse(instance,
                        "%s: no variable has value reference %u: allowed are those of %s variables in "
                        "modelDescription.xml",
                        function, reference, type_name(type));
    else
        instance_refuse(instance, "%s: %s (value reference %u) is %s: allowed are those of %s variables", function,
                        variable->name, reference, type_name(variable->type), type_name(type));
}

const Variable *access_find(const Instance *instance, const char *function, ValueReference reference, Type type) {
    const Variable *variable = variable_find(reference);
    if (variable != NULL && variable->type == type) return variable;
    refuse_reference(instance, function, reference, type);
    return NULL;
}

/* ---- reading ---- */

/* Do all variables exist with this type? Brings their values up to date. */
static bool can_read(Instance *instance, const char *function, const ValueReference vr[], size_t n, const void *value,
                     Type type) {
    if (!instance_is_in(instance, function, ~(unsigned)PHASE_INTERMEDIATE_INPUTS) ||
        !access_has_arrays(instance, function, n, vr, value))
        return false;
    unsigned groups = 0;
    for (size_t i = 0; i < n; i++) {
        const Variable *variable = access_find(instance, function, vr[i], type);
        if (variable == NULL) return false;
        groups |= variable->group;
    }
    return instance_provide(instance, function, groups);
}

static const void *address(const Instance *instance, ValueReference reference) {
    return (const char *)&instance->values + VARIABLES[reference].offset;
}

COLD static bool refuse_no_number(const Instance *instance, const char *function, ValueReference reference) {
    return instance_refuse(instance,
                           "%s: %s, or its derivative, is no finite number: allowed are inputs for which it is finite",
                           function, VARIABLES[reference].name);
}

/* Where a contact locks, no torque moves cam 2 that way: the edge of the stick band is infinite, and so is
 * their ratio. */
static bool may_be_infinite(ValueReference reference) {
    return reference == VR_TORQUE_LOAD || reference == VR_TORQUE_RELEASE || reference == VR_EFFICIENCY;
}

bool access_are_numbers(const Instance *instance, const char *function, const ValueReference vr[], size_t n,
                        const double value[]) {
    for (size_t i = 0; i < n; i++)
        if (!isfinite(value[i]) && (isnan(value[i]) || !may_be_infinite(vr[i])))
            return refuse_no_number(instance, function, vr[i]);
    return true;
}

bool access_get_reals(Instance *instance, const char *function, const ValueReference vr[], size_t n, double value[]) {
    if (!can_read(instance, function, vr, n, value, TYPE_REAL)) return false;
    for (size_t i = 0; i < n; i++) value[i] = *(const double *)address(instance, vr[i]);
    return access_are_numbers(instance, function, vr, n, value);
}

static int32_t integer_value(const Instance *instance, ValueReference reference) {
    const void *value = address(instance, reference);
    if (VARIABLES[reference].kind != KIND_COUNT) return *(const int *)value;
    const int64_t count = *(const int64_t *)value;
    return count < INT32_MAX ? (int32_t)count : INT32_MAX;
}

bool access_get_integers(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                         int32_t value[]) {
    if (!can_read(instance, function, vr, n, value, TYPE_INTEGER)) return false;
    for (size_t i = 0; i < n; i++) value[i] = integer_value(instance, vr[i]);
    return true;
}

bool access_get_booleans(Instance *instance, const char *function, const ValueReference vr[], size_t n, void *value,
                         WriteBoolean *write) {
    if (!can_read(instance, function, vr, n, value, TYPE_BOOLEAN)) return false;
    for (size_t i = 0; i < n; i++) write(value, i, *(const bool *)address(instance, vr[i]));
    return true;
}

bool access_get_texts(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                      const char *value[]) {
    if (!can_read(instance, function, vr, n, value, TYPE_STRING)) return false;
    for (size_t i = 0; i < n; i++) value[i] = address(instance, vr[i]);
    return true;
}

/* ---- setting ---- */

typedef struct {
    Params params;
    ModelInputs inputs;
} Draft; /* laid out as the beginning of Values, so that Variable.offset holds for both */

_Static_assert(offsetof(Values, model.params) == offsetof(Draft, params), "one offset for both");
_Static_assert(offsetof(Values, model.inputs) == offsetof(Draft, inputs), "one offset for both");
_Static_assert(VR_F_EXT < 16, "inputs come first, F_ext last: each has a bit in Run.with_rates");

static void *address_in(void *values, ValueReference reference) {
    return (char *)values + VARIABLES[reference].offset;
}

static bool can_set(const Instance *instance, const char *function, const ValueReference vr[], size_t n,
                    const void *value) {
    return instance_is_in(instance, function, PHASES_BEFORE_START | PHASES_RUNNING | PHASE_INTERMEDIATE_INPUTS) &&
           access_has_arrays(instance, function, n, vr, value);
}

/* Inside a step a master may set only the inputs that it has announced. */
static bool is_sampled(const Instance *instance, ValueReference reference) {
    return instance->run.phase != PHASE_INTERMEDIATE_INPUTS ||
           (reference < INPUTS_MAX && instance_samples(instance, reference));
}

/* The number of a continuous state of model exchange that a master may set now by its value reference; -1: no such. FMI
 * 2.0.1 (section 3.2.3, rule 5) and FMI 3.0.2 (section 3.2) allow these in continuous-time mode. */
static int settable_state(const Instance *instance, ValueReference reference) {
    if (instance->run.phase != PHASE_CONTINUOUS) return -1;
    int state = CONTINUOUS_STATES - 1;
    while (state >= 0 && model_state_reference(state) != reference) state--; /* at most CONTINUOUS_STATES turns */
    return state;
}

static const Variable *find_settable(const Instance *instance, const char *function, ValueReference reference,
                                     Type type) {
    const Variable *variable = access_find(instance, function, reference, type);
    if (variable == NULL) return NULL;
    const char *allowed = NULL;
    if (!is_sampled(instance, reference))
        allowed = "not asked for: allowed inside a step are the inputs among requiredIntermediateVariables";
    else if (variable->causality == CAUSALITY_INPUT || settable_state(instance, reference) >= 0) return variable;
    else if (variable->causality != CAUSALITY_PARAMETER) allowed = "calculated: allowed are parameters and inputs";
    else if (variable->variability == VARIABILITY_FIXED && instance_has_begun(instance))
        allowed = "fixed: allowed is to set it before the end of initialization mode";
    else if (instance->run.phase == PHASE_CONTINUOUS) allowed = "tunable: allowed is to set it in event mode";
    if (allowed == NULL) return variable;
    instance_refuse(instance, "%s: %s is %s", function, variable->name, allowed);
    return NULL;
}

static bool accepts(const Instance *instance, const char *function, const Variable *variable, double value) {
    return variable_allows(variable, value) ||
           instance_refuse(instance, "%s: %s = %s is refused: allowed is %s", function, variable->name,
                           shortest_decimal(value).text, variable_range(variable).text);
}

static bool accepts_text(const Instance *instance, const char *function, const Variable *variable, const char *value) {
    return (value != NULL && variable_allows(variable, (double)strlen(value))) ||
           instance_refuse(instance, "%s: %s = \"%.100s\" is refused: allowed is %s", function, variable->name,
                           value != NULL ? value : "NULL", variable_range(variable).text);
}

static bool are_good_inputs(const Instance *instance, const ValueReference vr[], size_t n, const double value[]) {
    for (size_t i = 0; i < n; i++) {
        const Variable *variable = variable_find(vr[i]);
        if (variable == NULL || variable->group != GROUP_INPUTS || !isfinite(value[i]) || !is_sampled(instance, vr[i]))
            return false;
    }
    return true;
}

double *access_input(Instance *instance, ValueReference reference) {
    return address_in(&instance->values, reference);
}

static bool are_good_reals(const Instance *instance, const char *function, const ValueReference vr[], size_t n,
                           const double value[]) {
    for (size_t i = 0; i < n; i++) {
        const Variable *variable = find_settable(instance, function, vr[i], TYPE_REAL);
        if (variable == NULL || !accepts(instance, function, variable, value[i])) return false;
    }
    return true;
}

static void write_reals(void *values, const ValueReference vr[], size_t n, const double value[]) {
    for (size_t i = 0; i < n; i++) *(double *)address_in(values, vr[i]) = value[i];
}

static void write_integers(void *values, const ValueReference vr[], size_t n, const int32_t value[]) {
    for (size_t i = 0; i < n; i++) *(int *)address_in(values, vr[i]) = value[i];
}

static Draft draft_of(const FmuModel *model) {
    return (Draft){.params = model->params, .inputs = model->inputs};
}

/* find_settable() lets pass only tunable parameters and inputs. */
static bool retune(Instance *instance, const char *function, const Draft *draft) {
    FmuModel *model = &instance->values.model;
    Fault fault;
    const HostArithmetic host = arithmetic_begin();
    const bool good = model_retune(model, &draft->params, &fault);
    arithmetic_end(host);
    if (!good) return instance_refuse(instance, "%s: %s", function, fault.text);
    model->inputs = draft->inputs;
    return true;
}

/* In continuous-time mode find_settable() lets pass only inputs and continuous states. */
static void write_inputs_and_states(Instance *instance, const ValueReference vr[], size_t n, const double value[]) {
    FmuModel *model = &instance->values.model;
    double x[CONTINUOUS_STATES + 1]; /* no array of length 0 in C */
    model_get_states(model, x);
    for (size_t i = 0; i < n; i++) {
        const int state = settable_state(instance, vr[i]);
        if (state >= 0) x[state] = value[i];
        else write_reals(&instance->values, vr + i, 1, value + i);
    }
    const HostArithmetic host = arithmetic_begin();
    model_set_states(model, x);
    arithmetic_end(host);
}

/* Of a call that does not set inputs alone, or that is refused. */
NOINLINE static bool set_any_reals(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                                   const double value[]) {
    if (!are_good_reals(instance, function, vr, n, value)) return false;
    if (instance->run.phase == PHASE_CONTINUOUS) {
        write_inputs_and_states(instance, vr, n, value);
    } else if (instance_has_begun(instance)) {
        Draft draft = draft_of(&instance->values.model);
        write_reals(&draft, vr, n, value);
        if (!retune(instance, function, &draft)) return false;
    } else {
        write_reals(&instance->values, vr, n, value);
    }
    instance_invalidate(instance);
    return true;
}

bool access_set_reals(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                      const double value[]) {
    if (!can_set(instance, function, vr, n, value)) return false;
    if (!are_good_inputs(instance, vr, n, value)) return set_any_reals(instance, function, vr, n, value);
    write_reals(&instance->values, vr, n, value);
    instance_invalidate(instance);
    return true;
}

/* Only Reals and Integers are tunable. So Booleans and Strings are set before the run begins, without a draft. */

bool access_set_integers(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                         const int32_t value[]) {
    if (!can_set(instance, function, vr, n, value)) return false;
    for (size_t i = 0; i < n; i++) {
        const Variable *variable = find_settable(instance, function, vr[i], TYPE_INTEGER);
        if (variable == NULL || !accepts(instance, function, variable, value[i])) return false;
    }
    if (n > 0 && instance_has_begun(instance)) {
        Draft draft = draft_of(&instance->values.model);
        write_integers(&draft, vr, n, value);
        if (!retune(instance, function, &draft)) return false;
    } else {
        write_integers(&instance->values, vr, n, value);
    }
    instance_invalidate(instance);
    return true;
}

bool access_set_booleans(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                         const void *value, ReadBoolean *read) {
    if (!can_set(instance, function, vr, n, value)) return false;
    for (size_t i = 0; i < n; i++)
        if (find_settable(instance, function, vr[i], TYPE_BOOLEAN) == NULL) return false;
    for (size_t i = 0; i < n; i++) *(bool *)address_in(&instance->values, vr[i]) = read(value, i);
    instance_invalidate(instance);
    return true;
}

bool access_set_texts(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                      const char *const value[]) {
    if (!can_set(instance, function, vr, n, value)) return false;
    for (size_t i = 0; i < n; i++) {
        const Variable *variable = find_settable(instance, function, vr[i], TYPE_STRING);
        if (variable == NULL || !accepts_text(instance, function, variable, value[i])) return false;
    }
    for (size_t i = 0; i < n; i++)
        strncpy(address_in(&instance->values, vr[i]), value[i],
                (size_t)LIMITS[vr[i]].max + 1); /* fills the rest with zeros */
    instance_invalidate(instance);
    return true;
}
