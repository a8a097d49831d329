/* modelDescription.xml of FMI 2.0. */
#include "emit.h"

static void put_type(Sink *sink, const Unit *unit) {
    put(sink, "    <SimpleType");
    put_attribute(sink, "name", unit->quantity);
    put(sink, "><Real");
    put_attribute(sink, "quantity", unit->quantity);
    put_attribute(sink, "unit", unit->name);
    if (unit->display[0] != '\0') put_attribute(sink, "displayUnit", unit->display);
    put(sink, "/></SimpleType>\n");
}

/* ---- variables ---- */

/* Place in the list of variables, from 1. */
static unsigned index_of(unsigned reference) {
    return reference + 1;
}

static void put_variable(Sink *sink, unsigned reference) {
    const Variable *variable = &VARIABLES[reference];
    put(sink, "    <ScalarVariable");
    put_variable_attributes(sink, reference);
    print(sink, ">\n      <%s", type_name(variable->type));
    if (variable->unit != UNIT_NONE) {
        put_attribute(sink, "declaredType", UNITS[variable->unit].quantity);
        put_attribute(sink, "unit", UNITS[variable->unit].name); /* for masters that do not look types up */
    }
    put_range(sink, variable);
    if (is_rate(reference)) put_number(sink, "derivative", index_of(state_of(reference)));
    if (is_state(reference)) put_attribute(sink, "reinit", "true"); /* end stops, and what friction stops */
    Digits room;
    if (has_start(variable))
        put_attribute(sink, "start", variable->type == TYPE_STRING ? "" : start_of(variable, &room));
    put(sink, "/>\n    </ScalarVariable>\n");
}

static void put_variables(Sink *sink) {
    put(sink, "  <ModelVariables>\n");
    for (unsigned i = 0; i < VARIABLE_COUNT; i++) put_variable(sink, i);
    put(sink, "  </ModelVariables>\n");
}

/* ---- model structure ---- */

static void put_unknowns(Sink *sink, const char *element, bool (*is_one)(unsigned), const Dependency *list) {
    print(sink, "    <%s>\n", element);
    for (unsigned i = 0; i < VARIABLE_COUNT; i++) {
        if (!is_one(i)) continue;
        print(sink, "      <Unknown index=\"%u\"", index_of(i));
        put_dependencies(sink, i, list, index_of(0));
        put(sink, "/>\n");
    }
    print(sink, "    </%s>\n", element);
}

static void put_structure(Sink *sink) {
    put(sink, "  <ModelStructure>\n");
    put_unknowns(sink, "Outputs", is_output, DEPENDENCIES);
    if (CONTINUOUS_STATES > 0) put_unknowns(sink, "Derivatives", is_rate, DEPENDENCIES);
    put_unknowns(sink, "InitialUnknowns", is_output_or_rate, INITIAL_DEPENDENCIES);
    put(sink, "  </ModelStructure>\n");
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

static void put_exchange(Sink *sink, char *const *sources) {
    put(sink, "  <ModelExchange\n   ");
    put_attribute(sink, "modelIdentifier", IDENTIFIER);
    put(sink,
        "\n    completedIntegratorStepNotNeeded=\"false\""
        "\n    canBeInstantiatedOnlyOncePerProcess=\"false\""
        "\n    canNotUseMemoryManagementFunctions=\"true\""
        "\n    canGetAndSetFMUstate=\"true\""
        "\n    canSerializeFMUstate=\"true\""
        "\n    providesDirectionalDerivative=\"true\">\n");
    put_sources(sink, sources);
    put(sink, "  </ModelExchange>\n");
}

static void put_co_simulation(Sink *sink, char *const *sources) {
    put(sink, "  <CoSimulation\n   ");
    put_attribute(sink, "modelIdentifier", IDENTIFIER);
    put(sink,
        "\n    canHandleVariableCommunicationStepSize=\"true\""
        "\n    canInterpolateInputs=\"true\"");
    print(sink, "\n    maxOutputDerivativeOrder=\"%d\"", (int)MAX_OUTPUT_ORDER);
    put(sink,
        "\n    canRunAsynchronuously=\"false\""
        "\n    canBeInstantiatedOnlyOncePerProcess=\"false\""
        "\n    canNotUseMemoryManagementFunctions=\"true\""
        "\n    canGetAndSetFMUstate=\"true\""
        "\n    canSerializeFMUstate=\"true\""
        "\n    providesDirectionalDerivative=\"true\">\n");
    put_sources(sink, sources);
    put(sink, "  </CoSimulation>\n");
}

void put_document(Sink *sink, const char *guid, char *const *sources) {
    put_head(sink, "2.0", "guid", guid);
    print(sink, "\n    numberOfEventIndicators=\"%d\">\n", (int)EVENT_INDICATORS);
    put_exchange(sink, sources);
    put_co_simulation(sink, sources);
    put_units(sink);
    put_types(sink, put_type);
    put_categories_and_experiment(sink);
    put_variables(sink);
    put_structure(sink);
    put(sink, "</fmiModelDescription>\n");
}
