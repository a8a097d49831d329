/* The FMU's variables as a table: one row of variables.def each, in the order of value references.
 * Knows of names, ranges and places; nothing here knows of FMI functions or of physics. */
#ifndef DUALCAM_VARIABLES_H
#define DUALCAM_VARIABLES_H

#include <stddef.h>
#include <stdint.h>

#include "fmi/model.h"

/* Keeps a row of variables.def that this FMU has and drops one that it has not. */
#if MODEL_BUILT == MODEL_FORWARD
#define IN_FORWARD(...) __VA_ARGS__
#define IN_INVERSE(...)
#else
#define IN_FORWARD(...)
#define IN_INVERSE(...) __VA_ARGS__
#endif
#define IN_BOTH(...) __VA_ARGS__

/* The same for a row that only FMI 3.0 has. */
#if FMI_VERSION == 3
#define IN_FORWARD_3(...) IN_FORWARD(__VA_ARGS__)
#define IN_INVERSE_3(...) IN_INVERSE(__VA_ARGS__)
#define IN_BOTH_3(...) __VA_ARGS__
#elif FMI_VERSION == 2
#define IN_FORWARD_3(...)
#define IN_INVERSE_3(...)
#define IN_BOTH_3(...)
#else
#error "FMI_VERSION must be 2 or 3"
#endif

/* As few bytes as its values need: the table has a row for each variable. */
#define SMALL __attribute__((packed))

typedef enum SMALL { TYPE_REAL, TYPE_INTEGER, TYPE_BOOLEAN, TYPE_STRING } Type;

/* How a value is stored and what is allowed beyond its range. */
typedef enum SMALL { KIND_REAL, KIND_INTEGER, KIND_SIGN, KIND_COUNT, KIND_BOOLEAN, KIND_TEXT } Kind;

typedef enum SMALL {
    CAUSALITY_PARAMETER,
    CAUSALITY_INPUT,
    CAUSALITY_OUTPUT,
    CAUSALITY_LOCAL,
    CAUSALITY_INDEPENDENT
} Causality;

typedef enum SMALL { VARIABILITY_FIXED, VARIABILITY_TUNABLE, VARIABILITY_DISCRETE, VARIABILITY_CONTINUOUS } Variability;

/* The struct that holds a value. As bits, so that a set of groups is a number. */
typedef enum SMALL {
    GROUP_PARAMS = 1,
    GROUP_INPUTS = 2,
    GROUP_STATE = 4,
    GROUP_MOTION = 8, /* this and the following are computed when somebody asks */
    GROUP_LOADS = 16,
    GROUP_CONTACT = 32,
    GROUP_ENERGY = 64,
    GROUP_AUDIT = 128,
    GROUP_STEP = 256,
    GROUP_TIME = 512,
    GROUP_INDICATORS = 1024
} Group;

typedef enum SMALL {
    UNIT_NONE,
#define UNIT(id, ...) UNIT_##id,
#include "variables.def"
    UNIT_COUNT
} UnitId;

/* Value references: 0, 1, 2, ... over the variables that this FMU has. */
typedef enum {
#define VARIABLE(model, kind, id, ...) IN_##model(VR_##id, )
#include "variables.def"
    VARIABLE_COUNT
} VariableId;

typedef struct {
    const char *name;
    int kg, m, s, rad;
    const char *quantity, *display;
    double factor;
} Unit;

typedef struct {
    uint32_t offset; /* bytes, in Values */
    Group group;
    Type type;
    Kind kind;
    Causality causality;
    Variability variability;
    UnitId unit;
    int8_t magnitude;       /* decimal exponent of the nominal value */
    double start, min, max; /* as in variables.def */
    const char *name;
} Variable; /* less its description, which only the XML has */

/* Everything that a variable can be read from. */
typedef struct {
    Machine machine;
    MachineOutputs outputs;
    struct {                                /* what only FMI 3.0 lists among the variables */
        double time;                        /* s */
        double indicator[EVENT_INDICATORS]; /* as in model exchange */
    } listed;
} Values;

extern const Unit UNITS[UNIT_COUNT];
extern const Variable VARIABLES[VARIABLE_COUNT];

/* The variable with that value reference, or NULL. */
static inline const Variable *variable_find(unsigned reference) {
    return reference < VARIABLE_COUNT ? &VARIABLES[reference] : NULL;
}

int tunable_known(unsigned reference); /* the Known that a tunable parameter is, or -1 */
const char *type_name(Type type);      /* as this version of FMI writes it: "Real", "Float64", ... */

/* Writes the start values of all parameters and inputs. */
void variables_start(Values *values);

/* A power of ten. */
double variable_nominal(const Variable *variable);

/* Range check of a Real, Integer or Boolean value, and of the length of a String. */
bool variable_allows(const Variable *variable, double value);

typedef struct {
    char text[32];
} Digits;

typedef struct {
    char text[80];
} Words;

Digits digits_of(double value);                   /* the fewest that read back as `value` */
Words variable_allowed(const Variable *variable); /* what variable_allows() accepts */

#endif
