#include "tools/emit.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <string.h>

#if MODEL_BUILT == MODEL_FORWARD
const char *const IDENTIFIER = "DualCamForward";
static const char *const DESCRIPTION =
    "Dual cylindrical cam, forward dynamics: torque on cam 2 turns it and lifts a spring-loaded follower in two "
    "grooves; stick and slip are resolved exactly";
#else
const char *const IDENTIFIER = "DualCamInverse";
static const char *const DESCRIPTION =
    "Dual cylindrical cam, inverse dynamics: the torque on cam 2 that turns it as imposed and lifts a spring-loaded "
    "follower in two grooves, friction included";
#endif
static const char *const VERSION = "0.2.0";

/* FNV-1a, 64 bits, from the standard offset basis and from a second one: 128 bits for the GUID. */
static const uint64_t HASH_BASIS[2] = {UINT64_C(0xcbf29ce484222325), UINT64_C(0x6c62272e07bb0142)};
static const uint64_t HASH_PRIME = UINT64_C(0x100000001b3);

void put(Sink *sink, const char *text) {
    for (const char *c = text; *c != '\0'; c++)
        for (int i = 0; i < 2; i++) sink->hash[i] = (sink->hash[i] ^ (unsigned char)*c) * HASH_PRIME;
    if (sink->file != NULL && fputs(text, sink->file) < 0) sink->failed = true;
}

void print(Sink *sink, const char *format, ...) {
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (length < 0 || (size_t)length >= sizeof text) sink->failed = true;
    put(sink, text);
}

void put_attribute(Sink *sink, const char *name, const char *value) {
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

void put_number(Sink *sink, const char *name, double value) {
    put_attribute(sink, name, shortest_decimal(value).text);
}

/* ---- head ---- */

void put_head(Sink *sink, const char *version, const char *guid_name, const char *guid) {
    const char *const attributes[][2] = {
        {"fmiVersion", version},
        {"modelName", IDENTIFIER},
        {guid_name, guid},
        {"description", DESCRIPTION},
        {"version", VERSION},
        {"license", "BSD-2-Clause"},
        {"generationTool", "emit_xml"},
        {"variableNamingConvention", "structured"},
    };
    put(sink, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription");
    for (size_t i = 0; i < sizeof attributes / sizeof attributes[0]; i++) {
        put(sink, "\n   ");
        put_attribute(sink, attributes[i][0], attributes[i][1]);
    }
}

void put_categories_and_experiment(Sink *sink) {
    put(sink, "  <LogCategories>\n"
              "    <Category name=\"logStatusError\" description=\"Calls that were refused, and why\"/>\n"
              "  </LogCategories>\n"
              "  <DefaultExperiment startTime=\"0\" stopTime=\"1\" tolerance=\"1e-9\" stepSize=\"0.001\"/>\n");
}

/* ---- units ---- */

static bool is_used(int unit) {
    for (unsigned i = 0; i < REFERENCE_END; i++)
        if (VARIABLES[i].unit == (UnitId)unit) return true;
    return false;
}

static void put_exponent(Sink *sink, const char *base, int exponent) {
    if (exponent != 0) put_number(sink, base, exponent);
}

void put_units(Sink *sink) {
    put(sink, "  <UnitDefinitions>\n");
    for (int id = UNIT_NONE + 1; id < UNIT_COUNT; id++) {
        const Unit *unit = &UNITS[id];
        if (!is_used(id)) continue;
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

void put_types(Sink *sink, void (*put_type)(Sink *sink, const Unit *unit)) {
    put(sink, "  <TypeDefinitions>\n");
    for (int id = UNIT_NONE + 1; id < UNIT_COUNT; id++)
        if (is_used(id)) put_type(sink, &UNITS[id]);
    put(sink, "  </TypeDefinitions>\n");
}

/* ---- variables ---- */

static const char *const DESCRIPTIONS[] = {
#define VARIABLE(model, vr, kind, id, group, field, name, causality, variability, unit, start, min, max, nominal,      \
                 text)                                                                                                 \
    IN_##model([VR_##id] = text, )
#include "variables.def"
};

static const Limits LIMITS_OF_ALL[] = {
#define VARIABLE(model, vr, kind, id, group, field, name, causality, variability, unit, start, min, max, nominal,      \
                 text)                                                                                                 \
    IN_##model([VR_##id] = {min, max, nominal}, )
#include "variables.def"
};

static const char *const CAUSALITIES[] = {[CAUSALITY_PARAMETER] = "parameter",
                                          [CAUSALITY_INPUT] = "input",
                                          [CAUSALITY_OUTPUT] = "output",
                                          [CAUSALITY_LOCAL] = "local",
                                          [CAUSALITY_INDEPENDENT] = "independent"};
static const char *const VARIABILITIES[] = {[VARIABILITY_FIXED] = "fixed",
                                            [VARIABILITY_TUNABLE] = "tunable",
                                            [VARIABILITY_DISCRETE] = "discrete",
                                            [VARIABILITY_CONTINUOUS] = "continuous"};

bool has_start(const Variable *variable) {
    return variable->causality == CAUSALITY_PARAMETER || variable->causality == CAUSALITY_INPUT;
}

const char *start_of(unsigned reference, ShortestDecimal *text) {
    const double start = variable_start(reference);
    if (VARIABLES[reference].type == TYPE_BOOLEAN) return start != 0.0 ? "true" : "false";
    *text = shortest_decimal(start);
    return text->text;
}

static void put_range(Sink *sink, const Variable *variable) {
    if (variable->type != TYPE_REAL && variable->type != TYPE_INTEGER) return;
    const Limits *limits = &LIMITS_OF_ALL[variable - VARIABLES];
    if (isfinite(limits->min)) put_number(sink, "min", limits->min);
    if (isfinite(limits->max)) put_number(sink, "max", limits->max);
    if (variable->type == TYPE_REAL && variable->causality != CAUSALITY_PARAMETER)
        put_number(sink, "nominal", limits->nominal);
}

void put_unit_and_range(Sink *sink, const Variable *variable) {
    if (variable->unit != UNIT_NONE) {
        put_attribute(sink, "declaredType", UNITS[variable->unit].quantity);
        put_attribute(sink, "unit", UNITS[variable->unit].name); /* for masters that do not look types up */
    }
    put_range(sink, variable);
}

void put_variable_attributes(Sink *sink, unsigned reference) {
    const Variable *variable = &VARIABLES[reference];
    put_attribute(sink, "name", variable->name);
    put_number(sink, "valueReference", reference);
    put_attribute(sink, "causality", CAUSALITIES[variable->causality]);
    put_attribute(sink, "variability", VARIABILITIES[variable->variability]);
    if (variable->causality != CAUSALITY_INPUT && variable->causality != CAUSALITY_INDEPENDENT)
        put_attribute(sink, "initial", has_start(variable) ? "exact" : "calculated");
    put_attribute(sink, "description", DESCRIPTIONS[reference]);
}

/* ---- model structure ---- */

void put_dependencies(Sink *sink, unsigned unknown, const Dependency *list, unsigned (*number)(unsigned reference)) {
    const char *separator = "";
    put(sink, " dependencies=\"");
    for (const Dependency *row = list; row->unknown != REFERENCE_END; row++) {
        if (row->unknown != unknown) continue;
        print(sink, "%s%u", separator, number(row->known));
        separator = " ";
    }
    separator = "\" dependenciesKind=\"";
    for (const Dependency *row = list; row->unknown != REFERENCE_END; row++) {
        if (row->unknown != unknown) continue;
        print(sink, "%s%s", separator, row->kind == CONSTANT ? "constant" : "dependent");
        separator = " ";
    }
    put(sink, "\"");
}

bool is_output(unsigned reference) {
    return VARIABLES[reference].causality == CAUSALITY_OUTPUT;
}

/* ---- program ---- */

static Sink sink_of(FILE *file) {
    return (Sink){.file = file, .hash = {HASH_BASIS[0], HASH_BASIS[1]}, .failed = false};
}

/* The arguments are the names of the FMU's source files. */
int main(int count, char *arguments[]) {
    if (count < 2) return 2;
    char *const *sources = arguments + 1; /* C ends the list with NULL */
    Sink blank = sink_of(NULL);
    put_document(&blank, "", sources);
    char guid[39];
    const uint64_t high = blank.hash[0], low = blank.hash[1];
    snprintf(guid, sizeof guid, "{%08" PRIx64 "-%04" PRIx64 "-%04" PRIx64 "-%04" PRIx64 "-%012" PRIx64 "}", high >> 32,
             high >> 16 & 0xffff, high & 0xffff, low >> 48, low & UINT64_C(0xffffffffffff));
    Sink printed = sink_of(stdout);
    put_document(&printed, guid, sources);
    return printed.failed || fflush(stdout) != 0 ? 1 : 0;
}
