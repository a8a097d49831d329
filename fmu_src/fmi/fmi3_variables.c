/* The functions of FMI 3.0 that read, set and describe variables. */
#include "fmi/access.h"
#include "fmi/dependencies.h"
#include "fmi/derivatives.h"
#include "fmi/fmi.h"

/* There is one value for each reference, since no variable is an array. */
static bool is_count(const Instance *instance, const char *function, const char *name, size_t n, size_t expected) {
    if (instance == NULL) return false;
    return n == expected ||
           instance_refuse(instance, "%s: %s = %zu: allowed is %zu, as many as variables", function, name, n, expected);
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Float64 values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_get_reals(instance, __func__, valueReferences, nValueReferences, values));
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Float64 values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_set_reals(instance, __func__, valueReferences, nValueReferences, values));
}

fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Int32 values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_get_integers(instance, __func__, valueReferences, nValueReferences, values));
}

fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Int32 values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_set_integers(instance, __func__, valueReferences, nValueReferences, values));
}

static void write_boolean(void *value, size_t i, bool content) {
    ((fmi3Boolean *)value)[i] = content;
}

/* Read as a byte: a byte other than 0 and 1 is not a value of bool, and counts as true. */
_Static_assert(sizeof(fmi3Boolean) == 1, "fmi3Boolean is a byte");
static bool read_boolean(const void *value, size_t i) {
    return ((const unsigned char *)value)[i] != 0;
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Boolean values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_get_booleans(instance, __func__, valueReferences, nValueReferences, values, write_boolean));
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Boolean values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_set_booleans(instance, __func__, valueReferences, nValueReferences, values, read_boolean));
}

fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         fmi3String values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_get_texts(instance, __func__, valueReferences, nValueReferences, values));
}

fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                         const fmi3String values[], size_t nValues) {
    return status_of(is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
                     access_set_texts(instance, __func__, valueReferences, nValueReferences, values));
}

/* ---- dependencies and derivatives ---- */

static const Dependency *next_dependency(const Dependency *row, fmi3ValueReference unknown) {
    while (row->unknown != REFERENCE_END && row->unknown != unknown) row++; /* at most one turn per dependency */
    return row->unknown != REFERENCE_END ? row : NULL;
}

/* Sets *first to the first dependency that holds in the present phase, or to NULL if there is none. */
static bool find_dependencies(const Instance *instance, const char *function, fmi3ValueReference unknown,
                              const Dependency **first) {
    if (instance == NULL) return false;
    *first = next_dependency(DEPENDENCIES, unknown);
    if (*first == NULL && next_dependency(INITIAL_DEPENDENCIES, unknown) == NULL)
        return instance_refuse(instance, "%s: value reference %u: allowed are those of unknowns in ModelStructure",
                               function, unknown);
    if (!instance_has_begun(instance)) {
        const Dependency *initial = next_dependency(INITIAL_DEPENDENCIES, unknown);
        if (initial != NULL) *first = initial; /* event indicators have no initial dependencies */
    }
    return true;
}

static size_t count_dependencies(const Dependency *row) {
    size_t n = 0;
    for (; row != NULL; row = next_dependency(row + 1, row->unknown)) n++; /* at most one turn per dependency */
    return n;
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference valueReference,
                                               size_t *nDependencies) {
    const Dependency *first;
    if (!find_dependencies(instance, __func__, valueReference, &first) ||
        !instance_has_pointer(instance, __func__, nDependencies, "nDependencies"))
        return fmi3Error;
    *nDependencies = count_dependencies(first);
    return fmi3OK;
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent,
                                       size_t elementIndicesOfDependent[], fmi3ValueReference independents[],
                                       size_t elementIndicesOfIndependents[], fmi3DependencyKind dependencyKinds[],
                                       size_t nDependencies) {
    const Dependency *row;
    if (!find_dependencies(instance, __func__, dependent, &row) ||
        !is_count(instance, __func__, "nDependencies", nDependencies, count_dependencies(row)) ||
        !instance_has_array(instance, __func__, nDependencies, elementIndicesOfDependent,
                            "elementIndicesOfDependent") ||
        !instance_has_array(instance, __func__, nDependencies, independents, "independents") ||
        !instance_has_array(instance, __func__, nDependencies, elementIndicesOfIndependents,
                            "elementIndicesOfIndependents") ||
        !instance_has_array(instance, __func__, nDependencies, dependencyKinds, "dependencyKinds"))
        return fmi3Error;
    /* At most one turn per dependency. */
    for (size_t i = 0; row != NULL; i++, row = next_dependency(row + 1, dependent)) {
        elementIndicesOfDependent[i] = elementIndicesOfIndependents[i] = 0; /* 0: all of a scalar */
        independents[i] = row->known;
        dependencyKinds[i] = row->kind == CONSTANT ? fmi3Constant : fmi3Dependent;
    }
    return fmi3OK;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                        size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity) {
    const Jacobian jacobian = {unknowns, knowns, nUnknowns, nKnowns};
    return status_of(is_count(instance, __func__, "nSeed", nSeed, nKnowns) &&
                     is_count(instance, __func__, "nSensitivity", nSensitivity, nUnknowns) &&
                     derivatives_product(instance, __func__, &jacobian, false, seed, sensitivity));
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                    size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity) {
    const Jacobian jacobian = {unknowns, knowns, nUnknowns, nKnowns};
    return status_of(is_count(instance, __func__, "nSeed", nSeed, nUnknowns) &&
                     is_count(instance, __func__, "nSensitivity", nSensitivity, nKnowns) &&
                     derivatives_product(instance, __func__, &jacobian, true, seed, sensitivity));
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[],
                                    size_t nValues) {
    const unsigned phases = PHASE_STEP | PHASE_INTERMEDIATE_OUTPUTS | PHASE_TERMINATED;
    return status_of(
        instance_is_co_simulation(instance, __func__) &&
        is_count(instance, __func__, "nValues", nValues, nValueReferences) &&
        derivatives_get_of_outputs(instance, __func__, phases, valueReferences, nValueReferences, orders, values));
}
