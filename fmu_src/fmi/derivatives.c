#include "fmi/derivatives.h"

#include <math.h>

#include "platform/arithmetic.h"

/* ---- time derivatives ---- */

static bool is_input_derivative(const Instance *instance, const char *function, ValueReference reference, int32_t order,
                                double value) {
    const Variable *variable = access_find(instance, function, reference, TYPE_REAL);
    if (variable == NULL) return false;
    if (variable->causality != CAUSALITY_INPUT)
        return instance_refuse(instance, "%s: %s is no input: allowed are inputs", function, variable->name);
    if (order < 1 || order > INPUT_ORDER)
        return instance_refuse(instance, "%s: %s: derivative of order %d: allowed is 1 to %d", function, variable->name,
                               order, (int)INPUT_ORDER);
    return isfinite(value) || instance_refuse(instance, "%s: derivative of %s = %s: allowed is any finite number",
                                              function, variable->name, shortest_decimal(value).text);
}

bool derivatives_set_of_inputs(Instance *instance, const char *function, const ValueReference vr[], size_t n,
                               const int32_t order[], const double value[]) {
    if (!instance_is_co_simulation(instance, function) ||
        !instance_is_in(instance, function, PHASES_BEFORE_START | PHASE_STEP) ||
        !access_has_arrays(instance, function, n, vr, value) ||
        !instance_has_array(instance, function, n, order, "order"))
        return false;
    for (size_t i = 0; i < n; i++)
        if (!is_input_derivative(instance, function, vr[i], order[i], value[i])) return false;
    if (n == 0) return true;
    if (instance->run.derivatives_given == 0) model_clear_input_derivatives(&instance->values.model.inputs);
    for (size_t i = 0; i < n; i++) {
        access_input(instance, vr[i])[order[i]] = value[i];
        instance->run.derivatives_given |= (uint16_t)(1u << vr[i]);
    }
    instance_invalidate(instance);
    return true;
}

static const Variable *find_output(const Instance *instance, const char *function, ValueReference reference,
                                   int32_t order) {
    const Variable *variable = access_find(instance, function, reference, TYPE_REAL);
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

/* Where an output does not exist, its derivatives do not exist either. */
bool derivatives_get_of_outputs(Instance *instance, const char *function, unsigned phases, const ValueReference vr[],
                                size_t n, const int32_t order[], double value[]) {
    if (!instance_is_in(instance, function, phases) || !access_has_arrays(instance, function, n, vr, value) ||
        !instance_has_array(instance, function, n, order, "order"))
        return false;
    unsigned groups = GROUP_STATE;
    for (size_t i = 0; i < n; i++) {
        const Variable *variable = find_output(instance, function, vr[i], order[i]);
        if (variable == NULL) return false;
        groups |= variable->group;
    }
    if (!instance_provide(instance, function, groups)) return false;
    const HostArithmetic host = arithmetic_begin();
    for (size_t i = 0; i < n; i++) value[i] = model_output_derivative(&instance->values.model, vr[i], order[i]);
    arithmetic_end(host);
    return access_are_numbers(instance, function, vr, n, value);
}

/* ---- partial derivatives ---- */

static bool is_unknown(const Instance *instance, const char *function, ValueReference reference) {
    const Variable *variable = access_find(instance, function, reference, TYPE_REAL);
    if (variable == NULL) return false;
    return model_unknown(reference) >= 0 ||
           instance_refuse(instance, "%s: unknown %s: allowed are outputs and derivatives of states", function,
                           variable->name);
}

static bool is_known(const Instance *instance, const char *function, ValueReference reference) {
    const Variable *variable = access_find(instance, function, reference, TYPE_REAL);
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

/* The partial derivatives of each unknown, by model_unknown(). */
typedef struct {
    Partials of[MODEL_UNKNOWNS];
} UnknownPartials;

/* Computes each unknown once, even if a master asks for the unknown several times. */
static bool compute_partials(const Instance *instance, const char *function, const Jacobian *j,
                             UnknownPartials *partials) {
    unsigned done = 0;
    for (size_t i = 0; i < j->unknowns; i++) {
        const int unknown = model_unknown(j->unknown[i]);
        Fault fault;
        if (done >> unknown & 1u) continue;
        const HostArithmetic host = arithmetic_begin();
        const bool good = model_partials(&instance->values.model, j->unknown[i], &partials->of[unknown], &fault);
        arithmetic_end(host);
        if (!good) return instance_refuse(instance, "%s: %s", function, fault.text);
        done |= 1u << unknown;
    }
    return true;
}

static double entry(const Jacobian *j, const UnknownPartials *partials, size_t unknown, size_t known) {
    return partials->of[model_unknown(j->unknown[unknown])].by[model_known(j->known[known])];
}

/* Does all of the matrix exist? The products are written only if it does. */
static bool compute_jacobian(Instance *instance, const char *function, const Jacobian *j, UnknownPartials *partials) {
    if (!instance_is_in(instance, function, PHASES_OF_RESULTS) ||
        !instance_has_array(instance, function, j->unknowns, j->unknown, "unknowns") ||
        !instance_has_array(instance, function, j->knowns, j->known, "knowns"))
        return false;
    for (size_t i = 0; i < j->unknowns; i++)
        if (!is_unknown(instance, function, j->unknown[i])) return false;
    for (size_t i = 0; i < j->knowns; i++)
        if (!is_known(instance, function, j->known[i])) return false;
    return instance_provide(instance, function, GROUP_STATE) && compute_partials(instance, function, j, partials);
}

bool derivatives_product(Instance *instance, const char *function, const Jacobian *j, bool transposed,
                         const double seed[], double product[]) {
    const ValueReference *from = transposed ? j->unknown : j->known, *to = transposed ? j->known : j->unknown;
    const size_t seeds = transposed ? j->unknowns : j->knowns, products = transposed ? j->knowns : j->unknowns;
    UnknownPartials partials;
    if (!compute_jacobian(instance, function, j, &partials) || !are_seeds(instance, function, from, seeds, seed) ||
        !instance_has_array(instance, function, products, product, "sensitivity"))
        return false;
    const HostArithmetic host = arithmetic_begin();
    for (size_t i = 0; i < products; i++) {
        product[i] = 0.0;
        for (size_t k = 0; k < seeds; k++)
            product[i] += (transposed ? entry(j, &partials, k, i) : entry(j, &partials, i, k)) * seed[k];
    }
    arithmetic_end(host);
    return access_are_numbers(instance, function, to, products, product);
}
