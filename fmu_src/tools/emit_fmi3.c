/* modelDescription.xml of FMI 3.0. Unknowns are referred to by their value references. The list of sources is in
 * another file, sources/buildDescription.xml (archive.py). */
#include "tools/emit.h"

static void put_type(Sink *sink, const Unit *unit) {
    put(sink, "    <Float64Type");
    put_attribute(sink, "name", unit->quantity);
    put_attribute(sink, "quantity", unit->quantity);
    put_attribute(sink, "unit", unit->name);
    if (unit->display[0] != '\0') put_attribute(sink, "displayUnit", unit->display);
    put(sink, "/>\n");
}

/* ---- variables ---- */

/* Can a master read or set the variable inside a step? */
static bool is_intermediate(const Variable *variable) {
    return variable->causality == CAUSALITY_OUTPUT || (SAMPLES_INPUTS && variable->causality == CAUSALITY_INPUT);
}

/* The continuous state whose derivative the variable is, or REFERENCE_END. */
static unsigned state_of(unsigned reference) {
    for (const StateDerivative *row = STATE_DERIVATIVES; row->derivative != REFERENCE_END; row++)
        if (row->derivative == reference) return row->state;
    return REFERENCE_END;
}

static bool is_derivative(unsigned reference) {
    return state_of(reference) != REFERENCE_END;
}

static bool is_state(unsigned reference) {
    for (const StateDerivative *row = STATE_DERIVATIVES; row->derivative != REFERENCE_END; row++)
        if (row->state == reference) return true;
    return false;
}

static bool is_output_or_derivative(unsigned reference) {
    return is_output(reference) || is_derivative(reference);
}

static void put_variable(Sink *sink, unsigned reference) {
    const Variable *variable = &VARIABLES[reference];
    print(sink, "    <%s", type_name(variable->type));
    put_variable_attributes(sink, reference);
    if (is_intermediate(variable)) put_attribute(sink, "intermediateUpdate", "true");
    put_unit_and_range(sink, variable);
    if (is_derivative(reference)) put_number(sink, "derivative", state_of(reference));
    if (is_state(reference)) put_attribute(sink, "reinit", "true"); /* at end stops, and at rest by friction */
    ShortestDecimal text;
    if (!has_start(variable)) {
        put(sink, "/>\n");
    } else if (variable->type == TYPE_STRING) {
        put(sink, "><Start value=\"\"/></String>\n");
    } else {
        put_attribute(sink, "start", start_of(reference, &text));
        put(sink, "/>\n");
    }
}

static void put_variables(Sink *sink) {
    put(sink, "  <ModelVariables>\n");
    for (unsigned i = 0; i < REFERENCE_END; i++)
        if (variable_find(i) != NULL) put_variable(sink, i);
    put(sink, "  </ModelVariables>\n");
}

/* ---- model structure ---- */

static unsigned reference_of(unsigned reference) {
    return reference;
}

static void put_unknowns(Sink *sink, const char *element, bool (*is_one)(unsigned), const Dependency *list) {
    for (unsigned i = 0; i < REFERENCE_END; i++) {
        if (!is_one(i)) continue;
        print(sink, "    <%s", element);
        put_number(sink, "valueReference", i);
        put_dependencies(sink, i, list, reference_of);
        put(sink, "/>\n");
    }
}

static bool is_indicator(unsigned reference) {
    return VARIABLES[reference].group == GROUP_INDICATORS;
}

static void put_structure(Sink *sink) {
    put(sink, "  <ModelStructure>\n");
    put_unknowns(sink, "Output", is_output, DEPENDENCIES);
    put_unknowns(sink, "ContinuousStateDerivative", is_derivative, DEPENDENCIES);
    put_unknowns(sink, "InitialUnknown", is_output_or_derivative, INITIAL_DEPENDENCIES);
    put_unknowns(sink, "EventIndicator", is_indicator, DEPENDENCIES);
    put(sink, "  </ModelStructure>\n");
}

/* ---- document ---- */

static void put_capabilities(Sink *sink, const char *element) {
    print(sink, "  <%s\n   ", element);
    put_attribute(sink, "modelIdentifier", IDENTIFIER);
    put(sink, "\n    canGetAndSetFMUState=\"true\""
              "\n    canSerializeFMUState=\"true\""
              "\n    providesDirectionalDerivatives=\"true\""
              "\n    providesAdjointDerivatives=\"true\""
              "\n    providesPerElementDependencies=\"true\"");
}

static void put_co_simulation(Sink *sink) {
    const char *const returns_early = RETURNS_EARLY ? "true" : "false";
    put_capabilities(sink, "CoSimulation");
    put(sink, "\n    canHandleVariableCommunicationStepSize=\"true\"");
    print(sink, "\n    maxOutputDerivativeOrder=\"%d\"", (int)MAX_OUTPUT_ORDER);
    put(sink, "\n    providesIntermediateUpdate=\"true\"");
    print(sink, "\n    mightReturnEarlyFromDoStep=\"%s\"", returns_early);
    print(sink, "\n    canReturnEarlyAfterIntermediateUpdate=\"%s\"", returns_early);
    put(sink, "\n    hasEventMode=\"true\"/>\n");
}

void put_document(Sink *sink, const char *guid, char *const *sources) {
    (void)sources;
    put_head(sink, "3.0", "instantiationToken", guid);
    put(sink, ">\n");
    put_capabilities(sink, "ModelExchange");
    put(sink, "\n    needsCompletedIntegratorStep=\"true\"/>\n");
    put_co_simulation(sink);
    put_units(sink);
    put_types(sink, put_type);
    put_categories_and_experiment(sink);
    put_variables(sink);
    put_structure(sink);
    put(sink, "</fmiModelDescription>\n");
}
