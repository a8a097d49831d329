#include "fmi/access.h"

#include <math.h>
#include <string.h>

#include "platform/attributes.h"

COLD static void refuse_arrays(const Instance *instance, const char *function, size_t n,
                               const ValueReference references[], const void *values) {
    if (instance_has_array(instance, function, n, references, "vr"))
        instance_has_array(instance, function, n, values, "value");
}

static bool has_arrays(const Instance *instance, const char *function, size_t n, const ValueReference references[],
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

/* The variable with that reference and type, or NULL. */
static const Variable *find(const Instance *instance, const char *function, ValueReference reference, Type type) {
    const Variable *variable = variable_find(reference);
    if (variable != NULL && variable->type == type) return variable;
    refuse_reference(instance, function, reference, type);
    return NULL;
}

/* ---- reading ---- */

/* All variables exist, have that type, and their values are up to date. */
static bool can_read(Instance *instance, const char *function, const ValueReference vr[], size_t n, const void *value,
                     Type type) {
    if (!instance_is_in(instance, function, ~(unsigned)PHASE_SAMPLING) || !has_arrays(instance, function, n, vr, value))
        return false;
    unsigned groups = 0;
    for (size_t i = 0; i < n; i++) {
        const Variable *variable = find(instance, function, vr[i], type);
        if (variable == NULL) return false;
        groups |= variable->group;
    }
    return instance_provide(instance, function, groups);
}

static const void *address(const Instance *instance, ValueReference reference) {
    return (const char *)&instance->values + VARIABLES[reference].offset;
}

bool access_get_reals(Instance *instance, const char *function, const ValueReference vr[], size_t n, double value[]) {
    if (!can_read(instance, function, vr, n, value, TYPE_REAL)) return false;
    for (size_t i = 0; i < n; i++) value[i] = *(const double *)address(instance, vr[i]);
    return true;
}

static int32_t integer_value(const Instance *instance, ValueReference reference) {
    const void *configuration = address(instance, reference);
    if (VARIABLES[reference].kind != KIND_COUNT) return *(const int *)configuration;
    const int64_t count = *(const int64_t *)configuration;
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
    MachineInputs inputs;
} Draft; /* the beginning of Values */

_Static_assert(offsetof(Values, machine.params) == offsetof(Draft, params), "one offset for both");
_Static_assert(offsetof(Values, machine.inputs) == offsetof(Draft, inputs), "one offset for both");
_Static_assert(VR_F_EXT < 16, "inputs come first, F_ext last: each has a bit in Run.with_rates");

static void *place_in(void *values, ValueReference reference) {
    return (char *)values + VARIABLES[reference].offset;
}

static bool can_set(const Instance *instance, const char *function, const ValueReference vr[], size_t n,
                    const void *value) {
    return instance_is_in(instance, function, PHASES_BEFORE_START | PHASES_RUNNING | PHASE_SAMPLING) &&
           has_arrays(instance, function, n, vr, value);
}

/* Inside a step a master sets only the inputs of which it has said that it will. */
static bool is_sampled(const Instance *instance, ValueReference reference) {
    return instance->run.phase != PHASE_SAMPLING || (reference < 16 && instance->following.sampled >> reference & 1u);
}

static const Variable *find_settable(const Instance *instance, const char *function, ValueReference reference,
                                     Type type) {
    const Variable *variable = find(instance, function, reference, type);
    if (variable == NULL) return NULL;
    const char *allowed = NULL;
    if (!is_sampled(instance, reference))
        allowed = "not asked for: allowed inside a step are the inputs among requiredIntermediateVariables";
    else if (variable->causality == CAUSALITY_INPUT) return variable;
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
                           digits_of(value).text, variable_allowed(variable).text);
}

static bool accepts_text(const Instance *instance, const char *function, const Variable *variable, const char *value) {
    return (value != NULL && variable_allows(variable, (double)strlen(value))) ||
           instance_refuse(instance, "%s: %s = \"%.100s\" is refused: allowed is %s", function, variable->name,
                           value != NULL ? value : "NULL", variable_allowed(variable).text);
}

static bool are_good_inputs(const ValueReference vr[], size_t n, const double value[]) {
    for (size_t i = 0; i < n; i++) {
        const Variable *variable = variable_find(vr[i]);
        if (variable == NULL || variable->group != GROUP_INPUTS || !isfinite(value[i])) return false;
    }
    return true;
}

static bool are_sampled(const Instance *instance, const ValueReference vr[], size_t n) {
    for (size_t i = 0; i < n; i++)
        if (!is_sampled(instance, vr[i])) return false;
    return true;
}

double *access_input(Instance *instance, ValueReference reference) {
    return place_in(&instance->values, reference);
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
    for (size_t i = 0; i < n; i++) *(double *)place_in(values, vr[i]) = value[i];
}

/* Only tunable parameters and inputs are left, see find_settable(). */
static bool retune(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                   const double value[]) {
    Machine *machine = &instance->values.machine;
    Draft draft = {.params = machine->params, .inputs = machine->inputs};
    write_reals(&draft, vr, n, value);
    Fault fault;
    if (!model_retune(machine, &draft.params, &fault)) return instance_refuse(instance, "%s: %s", function, fault.text);
    machine->inputs = draft.inputs;
    return true;
}

/* Not inputs alone. */
static bool set_any_reals(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                          const double value[]) {
    if (!are_good_reals(instance, function, vr, n, value)) return false;
    if (!instance_has_begun(instance)) write_reals(&instance->values, vr, n, value);
    else if (!retune(instance, function, vr, n, value)) return false;
    instance_changed(instance);
    return true;
}

bool access_set_reals(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                      const double value[]) {
    if (!can_set(instance, function, vr, n, value)) return false;
    const bool inside_step = instance->run.phase == PHASE_SAMPLING;
    if (!are_good_inputs(vr, n, value) || (inside_step && !are_sampled(instance, vr, n)))
        return set_any_reals(instance, function, vr, n, value);
    write_reals(&instance->values, vr, n, value);
    instance_changed(instance);
    return true;
}

/* Reals alone are tunable: the following are set where they are, before the run. */

bool access_set_integers(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                         const int32_t value[]) {
    if (!can_set(instance, function, vr, n, value)) return false;
    for (size_t i = 0; i < n; i++) {
        const Variable *variable = find_settable(instance, function, vr[i], TYPE_INTEGER);
        if (variable == NULL || !accepts(instance, function, variable, value[i])) return false;
    }
    for (size_t i = 0; i < n; i++) *(int *)place_in(&instance->values, vr[i]) = value[i];
    instance_changed(instance);
    return true;
}

bool access_set_booleans(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                         const void *value, ReadBoolean *read) {
    if (!can_set(instance, function, vr, n, value)) return false;
    for (size_t i = 0; i < n; i++)
        if (find_settable(instance, function, vr[i], TYPE_BOOLEAN) == NULL) return false;
    for (size_t i = 0; i < n; i++) *(bool *)place_in(&instance->values, vr[i]) = read(value, i);
    instance_changed(instance);
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
        strncpy(place_in(&instance->values, vr[i]), value[i], (size_t)VARIABLES[vr[i]].max + 1); /* zeros to the end */
    instance_changed(instance);
    return true;
}

/* ---- derivatives by time ---- */

static bool is_input_derivative(const Instance *instance, const char *function, ValueReference reference, int32_t order,
                                double value) {
    const Variable *variable = find(instance, function, reference, TYPE_REAL);
    if (variable == NULL) return false;
    if (variable->causality != CAUSALITY_INPUT)
        return instance_refuse(instance, "%s: %s is no input: allowed are inputs", function, variable->name);
    if (order < 1 || order > INPUT_ORDER)
        return instance_refuse(instance, "%s: %s: derivative of order %d: allowed is 1 to %d", function, variable->name,
                               order, (int)INPUT_ORDER);
    return isfinite(value) || instance_refuse(instance, "%s: derivative of %s = %.17g: allowed is any finite number",
                                              function, variable->name, value);
}

bool access_set_input_derivatives(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                                  const int32_t order[], const double value[]) {
    if (!instance_is_in(instance, function, PHASES_BEFORE_START | PHASE_STEP) ||
        !has_arrays(instance, function, n, vr, value) || !instance_has_array(instance, function, n, order, "order"))
        return false;
    for (size_t i = 0; i < n; i++)
        if (!is_input_derivative(instance, function, vr[i], order[i], value[i])) return false;
    if (n == 0) return true;
    if (instance->run.with_rates == 0) model_forget_rates(&instance->values.machine.inputs);
    for (size_t i = 0; i < n; i++) {
        access_input(instance, vr[i])[order[i]] = value[i];
        instance->run.with_rates |= (uint16_t)(1u << vr[i]);
    }
    instance_changed(instance);
    return true;
}

static const Variable *find_output(const Instance *instance, const char *function, ValueReference reference,
                                   int32_t order) {
    const Variable *variable = find(instance, function, reference, TYPE_REAL);
    if (variable == NULL) return NULL;
    if (variable->causality != CAUSALITY_OUTPUT) {
        instance_refuse(instance, "%s: %s is no output: allowed are outputs", function, variable->name);
        return NULL;
    }
    if (order < 1 || order > MAX_OUTPUT_ORDER) {
        instance_refuse(instance, "%s: %s: derivative of order %d: allowed is 1 to maxOutputDerivativeOrder = %d",
                        function, variable->name, order, (int)MAX_OUTPUT_ORDER);
        return NULL;
    }
    return variable;
}

/* Where an output is refused, so are its derivatives. */
bool access_get_output_derivatives(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                                   const int32_t order[], double value[]) {
    if (!instance_is_in(instance, function, ~(unsigned)PHASE_SAMPLING) ||
        !has_arrays(instance, function, n, vr, value) || !instance_has_array(instance, function, n, order, "order"))
        return false;
    unsigned groups = GROUP_STATE;
    for (size_t i = 0; i < n; i++) {
        const Variable *variable = find_output(instance, function, vr[i], order[i]);
        if (variable == NULL) return false;
        groups |= variable->group;
    }
    if (!instance_provide(instance, function, groups)) return false;
    for (size_t i = 0; i < n; i++) value[i] = model_output_derivative(&instance->values.machine, vr[i], order[i]);
    return true;
}

/* ---- partial derivatives ---- */

static bool is_unknown(const Instance *instance, const char *function, ValueReference reference) {
    const Variable *variable = find(instance, function, reference, TYPE_REAL);
    if (variable == NULL) return false;
    return model_row(reference) >= 0 ||
           instance_refuse(instance, "%s: unknown %s: allowed are outputs and derivatives of states", function,
                           variable->name);
}

static bool is_known(const Instance *instance, const char *function, ValueReference reference) {
    const Variable *variable = find(instance, function, reference, TYPE_REAL);
    if (variable == NULL) return false;
    return model_known(reference) >= 0 ||
           instance_refuse(instance, "%s: known %s: allowed are Real inputs, states and tunable parameters", function,
                           variable->name);
}

static bool are_seeds(const Instance *instance, const char *function, const ValueReference vr[], size_t n,
                      const double seed[]) {
    if (!instance_has_array(instance, function, n, seed, "seed")) return false;
    for (size_t i = 0; i < n; i++)
        if (!isfinite(seed[i]))
            return instance_refuse(instance, "%s: seed of %s = %g: allowed is any finite number", function,
                                   VARIABLES[vr[i]].name, seed[i]);
    return true;
}

/* By model_row(): each is computed once, also one that is asked for several times. */
typedef struct {
    Partials row[MODEL_ROWS];
} Rows;

static bool compute_rows(const Instance *instance, const char *function, const Jacobian *j, Rows *rows) {
    unsigned done = 0;
    for (size_t i = 0; i < j->unknowns; i++) {
        const int row = model_row(j->unknown[i]);
        Fault fault;
        if (done >> row & 1u) continue;
        if (!model_partials(&instance->values.machine, j->unknown[i], &rows->row[row], &fault))
            return instance_refuse(instance, "%s: %s", function, fault.text);
        done |= 1u << row;
    }
    return true;
}

static double entry(const Jacobian *j, const Rows *rows, size_t unknown, size_t known) {
    return rows->row[model_row(j->unknown[unknown])].by[model_known(j->known[known])];
}

/* All of the matrix exists. Nothing is written unless this is so. */
static bool is_jacobian(Instance *instance, const char *function, const Jacobian *j, Rows *rows) {
    if (!instance_is_in(instance, function, PHASE_INITIALIZATION | PHASES_RUNNING) ||
        !instance_has_array(instance, function, j->unknowns, j->unknown, "unknowns") ||
        !instance_has_array(instance, function, j->knowns, j->known, "knowns"))
        return false;
    for (size_t i = 0; i < j->unknowns; i++)
        if (!is_unknown(instance, function, j->unknown[i])) return false;
    for (size_t i = 0; i < j->knowns; i++)
        if (!is_known(instance, function, j->known[i])) return false;
    return instance_provide(instance, function, GROUP_STATE) && compute_rows(instance, function, j, rows);
}

bool access_directional(Instance *instance, const char *function, const Jacobian *j, const double seed[],
                        double product[]) {
    Rows rows;
    if (!is_jacobian(instance, function, j, &rows) || !are_seeds(instance, function, j->known, j->knowns, seed) ||
        !instance_has_array(instance, function, j->unknowns, product, "sensitivity"))
        return false;
    for (size_t i = 0; i < j->unknowns; i++) {
        product[i] = 0.0;
        for (size_t k = 0; k < j->knowns; k++) product[i] += entry(j, &rows, i, k) * seed[k];
    }
    return true;
}

bool access_adjoint(Instance *instance, const char *function, const Jacobian *j, const double seed[],
                    double product[]) {
    Rows rows;
    if (!is_jacobian(instance, function, j, &rows) || !are_seeds(instance, function, j->unknown, j->unknowns, seed) ||
        !instance_has_array(instance, function, j->knowns, product, "sensitivity"))
        return false;
    for (size_t k = 0; k < j->knowns; k++) {
        product[k] = 0.0;
        for (size_t i = 0; i < j->unknowns; i++) product[k] += seed[i] * entry(j, &rows, i, k);
    }
    return true;
}
