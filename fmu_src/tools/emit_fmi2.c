/* modelDescription.xml of FMI 2.0. */
#include "tools/emit.h"

static void put_type(Sink *sink, const Unit *unit) {
    put(sink, "    <SimpleType");
    put_attribute(sink, "name", unit->quantity);
    put(sink, "><Real");
    put_attribute(sink, "quantity", unit->quantity);
    put_attribute(sink, "unit", unit->name);
    if (unit->display[0] != '\0') put_attribute(sink, "displayUnit", unit->display);
    put(sink, "/></SimpleType>\n");
}

/* ---- variables ----
 * Each continuous state and each state derivative is listed a second time, under a name of its own. The co-simulation master Maestro 3.1.1 fails if an output is a state: it takes the entry in the list of
 * derivatives for an output derivative that it must hand on to interpolated inputs. */

static unsigned derivative_count(void) {
    unsigned n = 0;
    while (STATE_DERIVATIVES[n].derivative != REFERENCE_END) n++;
    return n;
}

/* The second names stand before the variable with this value reference, the first one of those that came later: their
 * indices stay when a variable is added. */
enum { AFTER_SECOND_NAMES = 139 };

/* Indices in the list of variables, from 1. */
static unsigned index_of(unsigned reference) {
    unsigned index = reference < AFTER_SECOND_NAMES ? 1 : 1 + 2 * derivative_count();
    for (unsigned i = 0; i < reference; i++) index += variable_find(i) != NULL ? 1 : 0;
    return index;
}

static unsigned index_of_state(unsigned row) {
    return index_of(AFTER_SECOND_NAMES - 1) + 1 + row;
}

static unsigned index_of_derivative(unsigned row) {
    return index_of_state(row) + derivative_count();
}

static unsigned index_of_known(unsigned reference) {
    for (unsigned row = 0; row < derivative_count(); row++)
        if (STATE_DERIVATIVES[row].state == reference) return index_of_state(row);
    return index_of(reference);
}

static void put_variable(Sink *sink, unsigned reference) {
    const Variable *variable = &VARIABLES[reference];
    put(sink, "    <ScalarVariable");
    put_variable_attributes(sink, reference);
    print(sink, ">\n      <%s", type_name(variable->type));
    put_unit_and_range(sink, variable);
    ShortestDecimal text;
    if (has_start(variable))
        put_attribute(sink, "start", variable->type == TYPE_STRING ? "" : start_of(reference, &text));
    put(sink, "/>\n    </ScalarVariable>\n");
}

static void put_second_name(Sink *sink, unsigned reference, const char *format, const char *state) {
    char name[64];
    snprintf(name, sizeof name, format, state);
    put(sink, "    <ScalarVariable");
    put_attribute(sink, "name", name);
    put_number(sink, "valueReference", reference);
    print(sink, " causality=\"local\" variability=\"continuous\" initial=\"calculated\"");
    print(sink, " description=\"Of model exchange: another name of %s\"", VARIABLES[reference].name);
    put(sink, ">\n      <Real");
    put_unit_and_range(sink, &VARIABLES[reference]);
}

static void put_states(Sink *sink) {
    for (const StateDerivative *row = STATE_DERIVATIVES; row->derivative != REFERENCE_END; row++) {
        put_second_name(sink, row->state, "state.%s", VARIABLES[row->state].name);
        put(sink, " reinit=\"true\"/>\n    </ScalarVariable>\n"); /* at end stops, and at rest by friction */
    }
    for (unsigned row = 0; row < derivative_count(); row++) {
        put_second_name(sink, STATE_DERIVATIVES[row].derivative, "der(state.%s)",
                        VARIABLES[STATE_DERIVATIVES[row].state].name);
        put_number(sink, "derivative", index_of_state(row));
        put(sink, "/>\n    </ScalarVariable>\n");
    }
}

static void put_variables_between(Sink *sink, unsigned begin, unsigned end) {
    for (unsigned i = begin; i < end; i++)
        if (variable_find(i) != NULL) put_variable(sink, i);
}

static void put_variables(Sink *sink) {
    put(sink, "  <ModelVariables>\n");
    put_variables_between(sink, 0, AFTER_SECOND_NAMES);
    put_states(sink);
    put_variables_between(sink, AFTER_SECOND_NAMES, REFERENCE_END);
    put(sink, "  </ModelVariables>\n");
}

/* ---- model structure ---- */

static void put_unknown(Sink *sink, unsigned index, unsigned reference, const Dependency *list) {
    print(sink, "      <Unknown index=\"%u\"", index);
    put_dependencies(sink, reference, list, index_of_known);
    put(sink, "/>\n");
}

static void put_outputs(Sink *sink, const Dependency *list) {
    for (unsigned i = 0; i < REFERENCE_END; i++)
        if (is_output(i)) put_unknown(sink, index_of(i), i, list);
}

static void put_derivatives(Sink *sink, const Dependency *list) {
    for (unsigned row = 0; row < derivative_count(); row++)
        put_unknown(sink, index_of_derivative(row), STATE_DERIVATIVES[row].derivative, list);
}

static void put_structure(Sink *sink) {
    put(sink, "  <ModelStructure>\n    <Outputs>\n");
    put_outputs(sink, DEPENDENCIES);
    put(sink, "    </Outputs>\n");
    if (derivative_count() > 0) {
        put(sink, "    <Derivatives>\n");
        put_derivatives(sink, DEPENDENCIES);
        put(sink, "    </Derivatives>\n");
    }
    put(sink, "    <InitialUnknowns>\n");
    put_outputs(sink, INITIAL_DEPENDENCIES);
    for (unsigned row = 0; row < derivative_count(); row++)
        put_unknown(sink, index_of_state(row), STATE_DERIVATIVES[row].state, INITIAL_DEPENDENCIES);
    put_derivatives(sink, INITIAL_DEPENDENCIES);
    put(sink, "    </InitialUnknowns>\n  </ModelStructure>\n");
}

/* ---- document ---- */

static void put_sources(Sink *sink, char *const *sources) {
    put(sink, "    <SourceFiles>\n");
    for (char *const *source = sources; *source != NULL; source++) {
        put(sink, "      <File");
        put_attribute(sink, "name", *source);
        put(sink, "/>\n");
    }
    put(sink, "    </SourceFiles>\n");
}

/* The last attributes, and the sources. */
static void put_common_capabilities(Sink *sink, char *const *sources) {
    put(sink, "\n    canBeInstantiatedOnlyOncePerProcess=\"false\""
              "\n    canNotUseMemoryManagementFunctions=\"true\""
              "\n    canGetAndSetFMUstate=\"true\""
              "\n    canSerializeFMUstate=\"true\""
              "\n    providesDirectionalDerivative=\"true\">\n");
    put_sources(sink, sources);
}

static void put_model_exchange(Sink *sink, char *const *sources) {
    put(sink, "  <ModelExchange\n   ");
    put_attribute(sink, "modelIdentifier", IDENTIFIER);
    put(sink, "\n    completedIntegratorStepNotNeeded=\"false\"");
    put_common_capabilities(sink, sources);
    put(sink, "  </ModelExchange>\n");
}

static void put_co_simulation(Sink *sink, char *const *sources) {
    put(sink, "  <CoSimulation\n   ");
    put_attribute(sink, "modelIdentifier", IDENTIFIER);
    put(sink, "\n    canHandleVariableCommunicationStepSize=\"true\""
              "\n    canInterpolateInputs=\"true\"");
    print(sink, "\n    maxOutputDerivativeOrder=\"%d\"", (int)MAX_OUTPUT_ORDER);
    put(sink, "\n    canRunAsynchronuously=\"false\"");
    put_common_capabilities(sink, sources);
    put(sink, "  </CoSimulation>\n");
}

void put_document(Sink *sink, const char *guid, char *const *sources) {
    put_head(sink, "2.0", "guid", guid);
    print(sink, "\n    numberOfEventIndicators=\"%d\">\n", (int)EVENT_INDICATORS);
    put_model_exchange(sink, sources);
    put_co_simulation(sink, sources);
    put_units(sink);
    put_types(sink, put_type);
    put_categories_and_experiment(sink);
    put_variables(sink);
    put_structure(sink);
    put(sink, "</fmiModelDescription>\n");
}
