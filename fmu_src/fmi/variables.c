#include "fmi/variables.h"

#include <math.h>
#include <stdio.h>

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

/* The member of Values that holds each group. */
#define PATH_PARAMS model.params
#define PATH_INPUTS model.inputs
#define PATH_STATE model.state
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
#define PATH_STEP_PARAMETERS outputs.step
#define PATH_TIME listed
#define PATH_INDICATORS listed

/* The C type of each kind. A row whose field has another type does not compile. */
typedef double TypeOf_REAL;
typedef int TypeOf_INTEGER;
typedef int TypeOf_SIGN;
typedef int64_t TypeOf_COUNT;
typedef bool TypeOf_BOOLEAN;
typedef char *TypeOf_TEXT;

#define VARIABLE(model, vr, kind, id, group, field, ...)                                                               \
    IN_##model(_Static_assert(_Generic(((Values *)0)->PATH_##group.field, TypeOf_##kind: 1, default: 0),               \
                              #id ": field of another type");)
#include "variables.def"

#define VARIABLE(model, vr, kind, id, group, field, name, causality, variability, ...)                                 \
    IN_##model(_Static_assert(VARIABILITY_##variability != VARIABILITY_TUNABLE || KIND_##kind == KIND_REAL ||          \
                                  KIND_##kind == KIND_INTEGER,                                                         \
                              #id ": only a Real or an Integer can be tunable");)
#include "variables.def"

enum {
    TYPE_OF_REAL = TYPE_REAL,
    TYPE_OF_INTEGER = TYPE_INTEGER,
    TYPE_OF_SIGN = TYPE_INTEGER,
    TYPE_OF_COUNT = TYPE_INTEGER,
    TYPE_OF_BOOLEAN = TYPE_BOOLEAN,
    TYPE_OF_TEXT = TYPE_STRING
};

const Variable VARIABLES[REFERENCE_END] = {
#define VARIABLE(model_, vr, kind_, id, group_, field, name_, causality_, variability_, unit_, start_, min_, max_,     \
                 nominal_, text)                                                                                       \
    IN_##model_([VR_##id] = {.offset = offsetof(Values, PATH_##group_.field),                                          \
                             .group = GROUP_##group_,                                                                  \
                             .type = (Type)TYPE_OF_##kind_,                                                            \
                             .kind = KIND_##kind_,                                                                     \
                             .causality = CAUSALITY_##causality_,                                                      \
                             .variability = VARIABILITY_##variability_,                                                \
                             .name = name_,                                                                            \
                             .unit = UNIT_##unit_}, )
#include "variables.def"
};

/* What each causality contributes to the limits. */
#define LIMITS_PARAMETER(id, min, max, nominal) [VR_##id] = {min, max, nominal},
#define LIMITS_INPUT LIMITS_PARAMETER
#define LIMITS_OUTPUT LIMITS_PARAMETER
#define LIMITS_LOCAL(id, min, max, nominal)
#define LIMITS_INDEPENDENT LIMITS_LOCAL

const Limits LIMITS[START_END] = {
#define VARIABLE(model, vr, kind, id, group, field, name, causality, variability, unit, start, min, max, nominal,      \
                 text)                                                                                                 \
    IN_##model(LIMITS_##causality(id, min, max, nominal))
#include "variables.def"
};

/* ---- values that look as if they were in another unit ---- */

#define SIDE_ABOVE false
#define SIDE_BELOW true
static const UnitGuard UNIT_GUARDS[] = {
#define UNIT_GUARD(model, id, side, limit, likely, other_unit, per_unit)                                               \
    IN_##model({VR_##id, SIDE_##side, limit, likely, other_unit, per_unit}, )
#include "unit_guards.def"
};
enum { UNIT_GUARD_COUNT = sizeof UNIT_GUARDS / sizeof UNIT_GUARDS[0] };

const UnitGuard *variables_strange(const Values *values, const UnitGuard *previous, double *value) {
    for (int i = previous == NULL ? 0 : (int)(previous - UNIT_GUARDS) + 1; i < UNIT_GUARD_COUNT; i++) {
        const UnitGuard *guard = &UNIT_GUARDS[i];
        if (previous != NULL && guard->variable == previous->variable) continue;
        *value = *(const double *)((const char *)values + VARIABLES[guard->variable].offset);
        if (guard->is_below ? *value > 0.0 && *value < guard->limit : fabs(*value) > guard->limit) return guard;
    }
    return NULL;
}

/* ---- start values ---- */

#ifndef MODEL_GUID
#error "MODEL_GUID, the GUID in modelDescription.xml, is given by the build"
#endif
_Static_assert(sizeof MODEL_GUID <= GUID_SIZE, "GUID_SIZE");

/* What each kind of row contributes to the numbers and to the texts of the block. */
#define NUMBER_REAL(id, start) start
#define NUMBER_INTEGER(id, start) start
#define NUMBER_SIGN(id, start) start
#define NUMBER_COUNT(id, start) start
#define NUMBER_BOOLEAN(id, start) start
#define NUMBER_TEXT(id, start) TEXT_##id
#define NUMBER_OF_PARAMETER(id, number) [VR_##id] = number,
#define NUMBER_OF_INPUT NUMBER_OF_PARAMETER
#define NUMBER_OF_OUTPUT NUMBER_OF_PARAMETER
#define NUMBER_OF_LOCAL(id, number)
#define NUMBER_OF_INDEPENDENT NUMBER_OF_LOCAL
#define START_TEXT_REAL(id, start)
#define START_TEXT_INTEGER(id, start)
#define START_TEXT_SIGN(id, start)
#define START_TEXT_COUNT(id, start)
#define START_TEXT_BOOLEAN(id, start)
#define START_TEXT_TEXT(id, start) [TEXT_##id] = start,

/* `volatile`: no optimiser may fold these bytes into the code, since they are replaced in the finished binary. */
__attribute__((used)) static const volatile StartBlock START_BLOCK = {
    .mark = "dualcam start values, layout 1\n",
    .size = sizeof(StartBlock),
    .number_count = START_END,
    .text_count = TEXT_COUNT,
    .text_size = START_TEXT_SIZE,
    .guid = MODEL_GUID,
    .number =
        {
#define VARIABLE(model, vr, kind, id, group, field, name, causality, variability, unit, start, ...)                    \
    IN_##model(NUMBER_OF_##causality(id, NUMBER_##kind(id, start)))
#include "variables.def"
        },
    .text =
        {
#define VARIABLE(model, vr, kind, id, group, field, name, causality, variability, unit, start, ...)                    \
    IN_##model(START_TEXT_##kind(id, start))
#include "platform/attributes.h"
#include "variables.def"
        },
};
_Static_assert(sizeof(StartBlock) == 48 + GUID_SIZE + START_END * sizeof(double) + (size_t)TEXT_COUNT * START_TEXT_SIZE,
               "padding in StartBlock");
_Static_assert((int)START_TEXT_SIZE <= (int)TABLE_PATH_SIZE, "a start value of a text must fit into the parameter");

/* Copies a text of less than `size` bytes. */
static void copy_text(char *to, const volatile char *from, size_t size) {
    for (size_t i = 0; i + 1 < size && from[i] != '\0'; i++) to[i] = from[i]; /* at most one turn per character */
}

Guid model_guid(void) {
    Guid guid = {""};
    copy_text(guid.text, START_BLOCK.guid, sizeof guid.text);
    return guid;
}

double variable_start(unsigned reference) {
    return START_BLOCK.number[reference];
}

static void write_start(unsigned reference, void *address) {
    const double start = variable_start(reference);
    switch (VARIABLES[reference].kind) {
        case KIND_REAL: *(double *)address = start; break;
        case KIND_INTEGER:
        case KIND_SIGN: *(int *)address = (int)start; break;
        case KIND_BOOLEAN: *(bool *)address = start != 0.0; break;
        case KIND_TEXT: copy_text(address, START_BLOCK.text[(int)start], START_TEXT_SIZE); break;
        case KIND_COUNT: break; /* no parameter and no input is of this kind */
    }
}

void variables_start(Values *values) {
    for (unsigned i = 0; i < START_END; i++)
        if ((VARIABLES[i].group & (GROUP_PARAMS | GROUP_INPUTS)) != 0)
            write_start(i, (char *)values + VARIABLES[i].offset);
}

/* ---- types and ranges ---- */

const char *type_name(Type type) {
    static const char *const names[] = {[TYPE_REAL] = FMI_VERSION == 2 ? "Real" : "Float64",
                                        [TYPE_INTEGER] = FMI_VERSION == 2 ? "Integer" : "Int32",
                                        [TYPE_BOOLEAN] = "Boolean",
                                        [TYPE_STRING] = "String"};
    return names[type];
}

bool variable_allows(const Variable *variable, double value) {
    if (variable->kind == KIND_SIGN && value == 0.0) return false;
    const Limits *limits = &LIMITS[variable - VARIABLES];
    return isfinite(value) && value >= limits->min && value <= limits->max;
}

COLD RangeText variable_range(const Variable *variable) {
    RangeText range;
    const Limits *limits = &LIMITS[variable - VARIABLES];
    const ShortestDecimal min = shortest_decimal(limits->min), max = shortest_decimal(limits->max);
    if (variable->kind == KIND_TEXT)
        snprintf(range.text, sizeof range.text, "\"\" or a text of at most %s bytes", max.text);
    else if (variable->kind == KIND_SIGN) snprintf(range.text, sizeof range.text, "-1 or +1");
    else if (limits->min == limits->max) snprintf(range.text, sizeof range.text, "only %s", min.text);
    else if (isfinite(limits->min) && isfinite(limits->max))
        snprintf(range.text, sizeof range.text, "%s to %s", min.text, max.text);
    else if (isfinite(limits->min)) snprintf(range.text, sizeof range.text, "any finite number from %s", min.text);
    else snprintf(range.text, sizeof range.text, "any finite number");
    return range;
}

int tunable_known(unsigned reference) {
    switch (reference) {
        case VR_CAM1_FRICTION: return KNOWN_FRICTION_1;
        case VR_CAM2_FRICTION: return KNOWN_FRICTION_2;
        case VR_CAM1_FRICTION_PEAK: return KNOWN_PEAK_1;
        case VR_CAM2_FRICTION_PEAK: return KNOWN_PEAK_2;
        case VR_CAM1_STRIBECK_VELOCITY: return KNOWN_STRIBECK_VELOCITY_1;
        case VR_CAM2_STRIBECK_VELOCITY: return KNOWN_STRIBECK_VELOCITY_2;
        case VR_CAM1_FRICTION_VISCOUS: return KNOWN_VISCOUS_1;
        case VR_CAM2_FRICTION_VISCOUS: return KNOWN_VISCOUS_2;
        case VR_CAM1_FRICTION_LOAD_EXPONENT: return KNOWN_LOAD_EXPONENT_1;
        case VR_CAM2_FRICTION_LOAD_EXPONENT: return KNOWN_LOAD_EXPONENT_2;
        case VR_CAM1_FRICTION_LOAD: return KNOWN_LOAD_1;
        case VR_CAM2_FRICTION_LOAD: return KNOWN_LOAD_2;
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
