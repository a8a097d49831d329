/* Host program of the build: prints the modelDescription.xml of the FMU that MODEL_BUILT chooses, from
 * variables.def. Its arguments are the names of the FMU's source files.
 *
 * The GUID is a hash of the text printed with an empty GUID, so equal descriptions have equal GUIDs and
 * there is no clock in it. */
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "variables.c" /* so that one file is all there is to compile */

#if MODEL_BUILT == MODEL_FORWARD
static const char *const IDENTIFIER = "DualCamForward";
static const char *const DESCRIPTION =
    "Dual cylindrical cam, forward dynamics: torque on cam 2 turns it and lifts a spring-loaded follower in two "
    "grooves; stick and slip are resolved exactly";
#else
static const char *const IDENTIFIER = "DualCamInverse";
static const char *const DESCRIPTION =
    "Dual cylindrical cam, inverse dynamics: the torque on cam 2 that turns it as imposed and lifts a spring-loaded "
    "follower in two grooves, friction included";
#endif
static const char *const VERSION = "0.1.0";

/* Where the text goes: always into the hash, and to `file` unless that is NULL. */
typedef struct {
    FILE *file;
    uint64_t hash[2];
    bool failed;
} Sink;

/* FNV-1a, 64 bits, from its standard offset basis and from another one: 128 bits for the GUID. */
static const uint64_t HASH_BASIS[2] = {UINT64_C(0xcbf29ce484222325), UINT64_C(0x6c62272e07bb0142)};
static const uint64_t HASH_PRIME = UINT64_C(0x100000001b3);

static void put(Sink *sink, const char *text) {
    for (const char *c = text; *c != '\0'; c++)
        for (int i = 0; i < 2; i++) sink->hash[i] = (sink->hash[i] ^ (unsigned char)*c) * HASH_PRIME;
    if (sink->file != NULL && fputs(text, sink->file) < 0) sink->failed = true;
}

__attribute__((format(printf, 2, 3))) static void print(Sink *sink, const char *format, ...) {
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (length < 0 || (size_t)length >= sizeof text) sink->failed = true;
    put(sink, text);
}

/* ` name="value"` with the value escaped. */
static void put_attribute(Sink *sink, const char *name, const char *value) {
    print(sink, " %s=\"", name);
    for (const char *c = value; *c != '\0'; c++) {
        switch (*c) {
            case '&': put(sink, "&amp;"); break;
            case '<': put(sink, "&lt;"); break;
            case '>': put(sink, "&gt;"); break;
            case '"': put(sink, "&quot;"); break;
            default: put(sink, (const char[]){*c, '\0'});
        }
    }
    put(sink, "\"");
}

static void put_number(Sink *sink, const char *name, double value) {
    put_attribute(sink, name, digits_of(value).text);
}

/* ---- units ---- */

static bool is_used(UnitId unit) {
    for (unsigned i = 0; i < VARIABLE_COUNT; i++)
        if (VARIABLES[i].unit == unit) return true;
    return false;
}

static void put_exponent(Sink *sink, const char *base, int exponent) {
    if (exponent != 0) put_number(sink, base, exponent);
}

static void put_units(Sink *sink) {
    put(sink, "  <UnitDefinitions>\n");
    for (int id = UNIT_NONE + 1; id < UNIT_COUNT; id++) {
        const Unit *unit = &UNITS[id];
        if (!is_used((UnitId)id)) continue;
        put(sink, "    <Unit");
        put_attribute(sink, "name", unit->name);
        put(sink, "><BaseUnit");
        put_exponent(sink, "kg", unit->kg);
        put_exponent(sink, "m", unit->m);
        put_exponent(sink, "s", unit->s);
        put_exponent(sink, "rad", unit->rad);
        put(sink, "/>");
        if (unit->display[0] != '\0') {
            put(sink, "<DisplayUnit");
            put_attribute(sink, "name", unit->display);
            put_number(sink, "factor", unit->factor);
            put(sink, "/>");
        }
        put(sink, "</Unit>\n");
    }
    put(sink, "  </UnitDefinitions>\n");
}

/* One type for each unit. */
static void put_types(Sink *sink) {
    put(sink, "  <TypeDefinitions>\n");
    for (int id = UNIT_NONE + 1; id < UNIT_COUNT; id++) {
        const Unit *unit = &UNITS[id];
        if (!is_used((UnitId)id)) continue;
        put(sink, "    <SimpleType");
        put_attribute(sink, "name", unit->quantity);
        put(sink, "><Real");
        put_attribute(sink, "quantity", unit->quantity);
        put_attribute(sink, "unit", unit->name);
        if (unit->display[0] != '\0') put_attribute(sink, "displayUnit", unit->display);
        put(sink, "/></SimpleType>\n");
    }
    put(sink, "  </TypeDefinitions>\n");
}

/* ---- variables ---- */

typedef struct {
    VariableId rate, state;
} Rate;

/* Ends with a row that belongs to no state: no list may be empty in C. */
static const Rate RATES[] = {
#define UNIT(...)
#define VARIABLE(...)
#define FOLLOWS(...)
#define STARTS_FROM(...)
#define RATE_OF(model, rate, state) IN_##model({VR_##rate, VR_##state},)
#include "variables.def"
#undef UNIT
#undef VARIABLE
#undef FOLLOWS
#undef STARTS_FROM
#undef RATE_OF
    {VARIABLE_COUNT, VARIABLE_COUNT}};

static const char *causality_name(Causality causality) {
    static const char *const names[] = {[CAUSALITY_PARAMETER] = "parameter",
                                        [CAUSALITY_INPUT] = "input",
                                        [CAUSALITY_OUTPUT] = "output",
                                        [CAUSALITY_LOCAL] = "local"};
    return names[causality];
}

static const char *variability_name(Variability variability) {
    static const char *const names[] = {[VARIABILITY_FIXED] = "fixed",
                                        [VARIABILITY_TUNABLE] = "tunable",
                                        [VARIABILITY_DISCRETE] = "discrete",
                                        [VARIABILITY_CONTINUOUS] = "continuous"};
    return names[variability];
}

static bool has_start(const Variable *variable) {
    return variable->causality == CAUSALITY_PARAMETER || variable->causality == CAUSALITY_INPUT;
}

static void put_start(Sink *sink, const Variable *variable) {
    switch (variable->type) {
        case TYPE_REAL:
        case TYPE_INTEGER: put_number(sink, "start", variable->start); break;
        case TYPE_BOOLEAN: put_attribute(sink, "start", variable->start != 0.0 ? "true" : "false"); break;
        case TYPE_STRING: put_attribute(sink, "start", ""); break;
    }
}

static void put_range(Sink *sink, const Variable *variable) {
    if (variable->type != TYPE_REAL && variable->type != TYPE_INTEGER) return;
    if (isfinite(variable->min)) put_number(sink, "min", variable->min);
    if (isfinite(variable->max)) put_number(sink, "max", variable->max);
    if (variable->type == TYPE_REAL && variable->causality != CAUSALITY_PARAMETER)
        put_number(sink, "nominal", variable->nominal);
}

/* Place in the list of variables, from 1. */
static unsigned index_of(VariableId id) {
    return (unsigned)id + 1;
}

/* The continuous state that it is the derivative of, or VARIABLE_COUNT. */
static VariableId state_of(unsigned reference) {
    for (const Rate *row = RATES; row->rate != VARIABLE_COUNT; row++)
        if (row->rate == reference) return row->state;
    return VARIABLE_COUNT;
}

/* `initial` is spelt out only where FMI has a choice: inputs must not have it. */
static void put_variable(Sink *sink, unsigned reference) {
    const Variable *variable = &VARIABLES[reference];
    put(sink, "    <ScalarVariable");
    put_attribute(sink, "name", variable->name);
    put_number(sink, "valueReference", reference);
    put_attribute(sink, "causality", causality_name(variable->causality));
    put_attribute(sink, "variability", variability_name(variable->variability));
    if (variable->causality != CAUSALITY_INPUT)
        put_attribute(sink, "initial", has_start(variable) ? "exact" : "calculated");
    put_attribute(sink, "description", variable->description);
    print(sink, ">\n      <%s", type_name(variable->type));
    if (variable->unit != UNIT_NONE) {
        put_attribute(sink, "declaredType", UNITS[variable->unit].quantity);
        put_attribute(sink, "unit", UNITS[variable->unit].name); /* for masters that do not look types up */
    }
    put_range(sink, variable);
    if (state_of(reference) != VARIABLE_COUNT) put_number(sink, "derivative", index_of(state_of(reference)));
    if (has_start(variable)) put_start(sink, variable);
    put(sink, "/>\n    </ScalarVariable>\n");
}

static void put_variables(Sink *sink) {
    put(sink, "  <ModelVariables>\n");
    for (unsigned i = 0; i < VARIABLE_COUNT; i++) put_variable(sink, i);
    put(sink, "  </ModelVariables>\n");
}

/* ---- model structure ---- */

typedef enum { DEPENDENT, CONSTANT } DependencyKind;

typedef struct {
    VariableId output, known;
    DependencyKind kind;
} Dependency;

/* Both end with a row that belongs to no output: no list may be empty in C. */
static const Dependency FOLLOWS[] = {
#define UNIT(...)
#define VARIABLE(...)
#define FOLLOWS(model, output, known, kind) IN_##model({VR_##output, VR_##known, kind},)
#define STARTS_FROM(...)
#define RATE_OF(...)
#include "variables.def"
#undef UNIT
#undef VARIABLE
#undef FOLLOWS
#undef STARTS_FROM
#undef RATE_OF
    {VARIABLE_COUNT, VARIABLE_COUNT, DEPENDENT}};

static const Dependency STARTS_FROM[] = {
#define UNIT(...)
#define VARIABLE(...)
#define FOLLOWS(...)
#define STARTS_FROM(model, output, known, kind) IN_##model({VR_##output, VR_##known, kind},)
#define RATE_OF(...)
#include "variables.def"
#undef UNIT
#undef VARIABLE
#undef FOLLOWS
#undef STARTS_FROM
#undef RATE_OF
    {VARIABLE_COUNT, VARIABLE_COUNT, DEPENDENT}};

static void put_dependencies(Sink *sink, VariableId output, const Dependency *list) {
    const char *separator = "";
    put(sink, " dependencies=\"");
    for (const Dependency *row = list; row->output != VARIABLE_COUNT; row++) {
        if (row->output != output) continue;
        print(sink, "%s%u", separator, index_of(row->known));
        separator = " ";
    }
    separator = "\" dependenciesKind=\"";
    for (const Dependency *row = list; row->output != VARIABLE_COUNT; row++) {
        if (row->output != output) continue;
        print(sink, "%s%s", separator, row->kind == CONSTANT ? "constant" : "dependent");
        separator = " ";
    }
    put(sink, "\"");
}

static bool is_output(unsigned reference) {
    return VARIABLES[reference].causality == CAUSALITY_OUTPUT;
}

static bool is_rate(unsigned reference) {
    return state_of(reference) != VARIABLE_COUNT;
}

static bool is_output_or_rate(unsigned reference) {
    return is_output(reference) || is_rate(reference);
}

static void put_unknowns(Sink *sink, const char *element, bool (*is_one)(unsigned), const Dependency *list) {
    print(sink, "    <%s>\n", element);
    for (unsigned i = 0; i < VARIABLE_COUNT; i++) {
        if (!is_one(i)) continue;
        print(sink, "      <Unknown index=\"%u\"", index_of((VariableId)i));
        put_dependencies(sink, (VariableId)i, list);
        put(sink, "/>\n");
    }
    print(sink, "    </%s>\n", element);
}

static void put_structure(Sink *sink) {
    put(sink, "  <ModelStructure>\n");
    put_unknowns(sink, "Outputs", is_output, FOLLOWS);
    if (CONTINUOUS_STATES > 0) put_unknowns(sink, "Derivatives", is_rate, FOLLOWS);
    put_unknowns(sink, "InitialUnknowns", is_output_or_rate, STARTS_FROM);
    put(sink, "  </ModelStructure>\n");
}

/* ---- document ---- */

static void put_head(Sink *sink, const char *guid) {
    put(sink, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription\n   ");
    put_attribute(sink, "fmiVersion", "2.0");
    put(sink, "\n   ");
    put_attribute(sink, "modelName", IDENTIFIER);
    put(sink, "\n   ");
    put_attribute(sink, "guid", guid);
    put(sink, "\n   ");
    put_attribute(sink, "description", DESCRIPTION);
    put(sink, "\n   ");
    put_attribute(sink, "version", VERSION);
    put(sink, "\n   ");
    put_attribute(sink, "license", "BSD-2-Clause");
    put(sink, "\n   ");
    put_attribute(sink, "generationTool", "emit_xml");
    put(sink, "\n   ");
    put_attribute(sink, "variableNamingConvention", "structured");
    print(sink, "\n    numberOfEventIndicators=\"%d\">\n", (int)EVENT_INDICATORS);
}

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

static void put_document(Sink *sink, const char *guid, char *const *sources) {
    put_head(sink, guid);
    put_exchange(sink, sources);
    put_co_simulation(sink, sources);
    put_units(sink);
    put_types(sink);
    put(sink,
        "  <LogCategories>\n"
        "    <Category name=\"logStatusError\" description=\"Calls that were refused, and why\"/>\n"
        "  </LogCategories>\n"
        "  <DefaultExperiment startTime=\"0\" stopTime=\"1\" tolerance=\"1e-9\" stepSize=\"0.001\"/>\n");
    put_variables(sink);
    put_structure(sink);
    put(sink, "</fmiModelDescription>\n");
}

static Sink sink_of(FILE *file) {
    return (Sink){.file = file, .hash = {HASH_BASIS[0], HASH_BASIS[1]}, .failed = false};
}

int main(int count, char *arguments[]) {
    if (count < 2) return 2;
    char *const *sources = arguments + 1; /* C ends the list with NULL */
    Sink blank = sink_of(NULL);
    put_document(&blank, "", sources);
    char guid[39];
    const uint64_t high = blank.hash[0], low = blank.hash[1];
    snprintf(guid, sizeof guid, "{%08" PRIx64 "-%04" PRIx64 "-%04" PRIx64 "-%04" PRIx64 "-%012" PRIx64 "}",
             high >> 32, high >> 16 & 0xffff, high & 0xffff, low >> 48, low & UINT64_C(0xffffffffffff));
    Sink printed = sink_of(stdout);
    put_document(&printed, guid, sources);
    return printed.failed || fflush(stdout) != 0 ? 1 : 0;
}
