#include "fmi/variables.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const Unit UNITS[UNIT_COUNT] = {
#define UNIT(id, unit_name, kg_, m_, s_, rad_, quantity_, display_, factor_)                                           \
    [UNIT_##id] = {.name = unit_name,                                                                                  \
                   .kg = kg_,                                                                                          \
                   .m = m_,                                                                                            \
                   .s = s_,                                                                                            \
                   .rad = rad_,                                                                                        \
                   .quantity = quantity_,                                                                              \
                   .display = display_,                                                                                \
                   .factor = factor_},
#include "variables.def"
};

/* Where each group is in Values. */
#define PATH_PARAMS machine.params
#define PATH_INPUTS machine.inputs
#define PATH_STATE machine.state
#define PATH_MOTION outputs.motion
#define PATH_LOADS outputs.loads
#if MODEL_BUILT == MODEL_FORWARD
#define PATH_CONTACT outputs.loads
#else
#define PATH_CONTACT outputs.contact
#endif
#define PATH_ENERGY outputs.energy
#define PATH_AUDIT outputs.audit
#define PATH_STEP outputs.step
#define PATH_TIME listed
#define PATH_INDICATORS listed

/* The C type of each kind: a field of another type does not compile. */
typedef double TypeOf_REAL;
typedef int TypeOf_INTEGER;
typedef int TypeOf_SIGN;
typedef int64_t TypeOf_COUNT;
typedef bool TypeOf_BOOLEAN;
typedef char *TypeOf_TEXT;

#define VARIABLE(model, kind, id, group, field, ...)                                                                   \
    IN_##model(_Static_assert(_Generic(((Values *)0)->PATH_##group.field, TypeOf_##kind: 1, default: 0),               \
                              #id ": field of another type");)
#include "variables.def"

#define VARIABLE(model, kind, id, group, field, name, causality, variability, ...)                                     \
    IN_##model(_Static_assert(VARIABILITY_##variability != VARIABILITY_TUNABLE || KIND_##kind == KIND_REAL,            \
                              #id ": only a Real can be tunable");)
#include "variables.def"

enum {
    TYPE_OF_REAL = TYPE_REAL,
    TYPE_OF_INTEGER = TYPE_INTEGER,
    TYPE_OF_SIGN = TYPE_INTEGER,
    TYPE_OF_COUNT = TYPE_INTEGER,
    TYPE_OF_BOOLEAN = TYPE_BOOLEAN,
    TYPE_OF_TEXT = TYPE_STRING
};

/* Of a power of ten; emit.c refuses other nominal values. */
#define MAGNITUDE(x)                                                                                                   \
    ((x) >= 1e4    ? 4                                                                                                 \
     : (x) >= 1e3  ? 3                                                                                                 \
     : (x) >= 1e2  ? 2                                                                                                 \
     : (x) >= 1e1  ? 1                                                                                                 \
     : (x) >= 1.0  ? 0                                                                                                 \
     : (x) >= 1e-1 ? -1                                                                                                \
     : (x) >= 1e-2 ? -2                                                                                                \
                   : -3)

const Variable VARIABLES[VARIABLE_COUNT] = {
#define VARIABLE(model_, kind_, id, group_, field, name_, causality_, variability_, unit_, start_, min_, max_,         \
                 nominal_, text)                                                                                       \
    IN_##model_([VR_##id] = {.offset = offsetof(Values, PATH_##group_.field),                                          \
                             .group = GROUP_##group_,                                                                  \
                             .type = (Type)TYPE_OF_##kind_,                                                            \
                             .kind = KIND_##kind_,                                                                     \
                             .causality = CAUSALITY_##causality_,                                                      \
                             .variability = VARIABILITY_##variability_,                                                \
                             .start = start_,                                                                          \
                             .min = min_,                                                                              \
                             .max = max_,                                                                              \
                             .magnitude = MAGNITUDE(nominal_),                                                         \
                             .name = name_,                                                                            \
                             .unit = UNIT_##unit_}, )
#include "variables.def"
};

const char *type_name(Type type) {
    static const char *const names[] = {[TYPE_REAL] = FMI_VERSION == 2 ? "Real" : "Float64",
                                        [TYPE_INTEGER] = FMI_VERSION == 2 ? "Integer" : "Int32",
                                        [TYPE_BOOLEAN] = "Boolean",
                                        [TYPE_STRING] = "String"};
    return names[type];
}

static void write_start(const Variable *variable, void *address) {
    switch (variable->kind) {
        case KIND_REAL: *(double *)address = variable->start; break;
        case KIND_INTEGER:
        case KIND_SIGN: *(int *)address = (int)variable->start; break;
        case KIND_BOOLEAN: *(bool *)address = variable->start != 0.0; break;
        case KIND_TEXT: *(char *)address = '\0'; break;
        case KIND_COUNT: break; /* never a parameter or an input */
    }
}

void variables_start(Values *values) {
    for (size_t i = 0; i < VARIABLE_COUNT; i++) {
        const Variable *variable = &VARIABLES[i];
        if ((variable->group & (GROUP_PARAMS | GROUP_INPUTS)) != 0)
            write_start(variable, (char *)values + variable->offset);
    }
}

double variable_nominal(const Variable *variable) {
    double power = 1.0;
    for (int k = 0; k < abs(variable->magnitude); k++) power *= 10.0;
    return variable->magnitude < 0 ? 1.0 / power : power;
}

bool variable_allows(const Variable *variable, double value) {
    if (variable->kind == KIND_SIGN && value == 0.0) return false;
    return isfinite(value) && value >= variable->min && value <= variable->max;
}

Digits digits_of(double value) {
    Digits shortest;
    if (fabs(value) < 1e15 && value == floor(value)) { /* 50000, not 5e+04 */
        snprintf(shortest.text, sizeof shortest.text, "%.0f", value);
        return shortest;
    }
    for (int digits = 1; digits <= 17; digits++) {
        snprintf(shortest.text, sizeof shortest.text, "%.*g", digits, value);
        if (strtod(shortest.text, NULL) == value) break;
    }
    return shortest;
}

Words variable_allowed(const Variable *variable) {
    Words words;
    const Digits min = digits_of(variable->min), max = digits_of(variable->max);
    if (variable->kind == KIND_TEXT)
        snprintf(words.text, sizeof words.text, "\"\" or a text of at most %s bytes", max.text);
    else if (variable->kind == KIND_SIGN) snprintf(words.text, sizeof words.text, "-1 or +1");
    else if (variable->min == variable->max) snprintf(words.text, sizeof words.text, "only %s", min.text);
    else if (isfinite(variable->min) && isfinite(variable->max))
        snprintf(words.text, sizeof words.text, "%s to %s", min.text, max.text);
    else if (isfinite(variable->min)) snprintf(words.text, sizeof words.text, "any finite number from %s", min.text);
    else snprintf(words.text, sizeof words.text, "any finite number");
    return words;
}

int tunable_known(unsigned reference) {
    switch (reference) {
        case VR_CAM1_FRICTION: return KNOWN_FRICTION_1;
        case VR_CAM2_FRICTION: return KNOWN_FRICTION_2;
        case VR_SPRING_PRELOAD: return KNOWN_PRELOAD;
        case VR_SPRING_STIFFNESS: return KNOWN_STIFFNESS;
        case VR_SPRING_STIFFNESS2: return KNOWN_STIFFNESS2;
        case VR_SPRING_STIFFNESS3: return KNOWN_STIFFNESS3;
        case VR_DAMPER_C_LOAD: return KNOWN_C_LOAD;
        case VR_DAMPER_Q_LOAD: return KNOWN_Q_LOAD;
        case VR_DAMPER_C_RELEASE: return KNOWN_C_RELEASE;
        case VR_DAMPER_Q_RELEASE: return KNOWN_Q_RELEASE;
        default: return -1;
    }
}
