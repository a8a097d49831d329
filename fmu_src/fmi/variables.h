/* The FMU's variables as a table: one entry for each row of variables.def, at its value reference. The table
 * holds names, ranges, and where each value is; it knows neither FMI functions nor physics. */
#ifndef DUALCAM_VARIABLES_H
#define DUALCAM_VARIABLES_H

#include <stddef.h>
#include <stdint.h>

#include "fmi/model.h"

/* Keep the rows of variables.def that this FMU has; the other rows become nothing. */
#if MODEL_BUILT == MODEL_FORWARD
#define IN_FORWARD(...) __VA_ARGS__
#define IN_INVERSE(...)
#define EACH(forward, inverse) forward
#else
#define IN_FORWARD(...)
#define IN_INVERSE(...) __VA_ARGS__
#define EACH(forward, inverse) inverse
#endif
#define IN_BOTH(...) __VA_ARGS__

/* Rows that only FMI 3.0 has. */
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

typedef enum { TYPE_REAL, TYPE_INTEGER, TYPE_BOOLEAN, TYPE_STRING } Type;

/* How a value is stored, and what is allowed besides its range. */
typedef enum { KIND_REAL, KIND_INTEGER, KIND_SIGN, KIND_COUNT, KIND_BOOLEAN, KIND_TEXT } Kind;

typedef enum {
    CAUSALITY_PARAMETER,
    CAUSALITY_INPUT,
    CAUSALITY_OUTPUT,
    CAUSALITY_LOCAL,
    CAUSALITY_INDEPENDENT
} Causality;

typedef enum { VARIABILITY_FIXED, VARIABILITY_TUNABLE, VARIABILITY_DISCRETE, VARIABILITY_CONTINUOUS } Variability;

/* The struct that holds a value. Each group is one bit, so that a set of groups is a number. */
typedef enum {
    GROUP_PARAMS = 1,
    GROUP_INPUTS = 2,
    GROUP_STATE = 4,
    GROUP_MOTION = 8, /* this group and the following ones are computed when a master reads them */
    GROUP_LOADS = 16,
    GROUP_CONTACT = 32,
    GROUP_ENERGY = 64,
    GROUP_AUDIT = 128,
    GROUP_STEP = 256,
    GROUP_STEP_PARAMETERS = 512,
    GROUP_TIME = 1024,
    GROUP_INDICATORS = 2048
} Group;

typedef enum {
    UNIT_NONE,
#define UNIT(id, ...) UNIT_##id,
#include "variables.def"
    UNIT_COUNT
} UnitId;

/* Value references. */
typedef enum {
#define VARIABLE(model, vr, kind, id, ...) IN_##model(VR_##id = vr, )
#include "variables.def"
} VariableId;

/* The size of this union is one more than the largest value reference of the FMU. */
typedef union {
#define VARIABLE(model, vr, kind, id, ...) IN_##model(char up_to_##id[vr + 1];)
#include "variables.def"
} Places;
enum { REFERENCE_END = sizeof(Places) };

typedef struct {
    const char *name;
    int kg, m, s, rad;
    const char *quantity, *display;
    double factor;
} Unit;

/* Small types: the table is a large part of the binary. */
typedef struct {
    const char *name;
    uint32_t offset;   /* bytes, in Values */
    uint16_t group;    /* Group */
    uint8_t type;      /* Type */
    uint8_t kind;      /* Kind */
    uint8_t causality; /* Causality */
    uint8_t variability;
    uint8_t unit; /* UnitId */
} Variable;       /* the description stands only in the XML */

/* Range and order of magnitude of a value, as in variables.def. */
typedef struct {
    double min, max, nominal;
} Limits;

/* When the value of a parameter, which is allowed, looks as if it were in another unit. */
typedef struct {
    uint16_t variable; /* VariableId */
    bool is_below;     /* strange is a value between 0 and the limit; else a magnitude above the limit */
    double limit;
    const char *likely;     /* what a strange value looks like */
    const char *other_unit; /* the likely unit, */
    double per_unit;        /* and how many of it make one unit of the variable */
} UnitGuard;

/* All values that variables have. */
typedef struct {
    FmuModel model;
    ModelOutputs outputs;
    struct {                                /* variables of FMI 3.0 alone */
        double time;                        /* s */
        double indicator[EVENT_INDICATORS]; /* event indicators of model exchange */
    } listed;
} Values;

/* Start values and GUID of an FMU are one block of bytes in its binary, which variables.c holds. The Python function
 * export_fmu() (dualcam/export/start_block.py) finds the block in a finished binary by its mark, and replaces GUID,
 * numbers and texts: so an FMU gets own start values without a compiler. Numbers are little-endian on every platform of
 * the FMUs. Any change of the layout needs another mark. */
enum { GUID_SIZE = 64, START_TEXT_SIZE = 128 }; /* bytes, terminating zero included */

/* The variables whose values are texts: 0, 1, ... */
#define TEXT_ID_REAL(id)
#define TEXT_ID_INTEGER(id)
#define TEXT_ID_SIGN(id)
#define TEXT_ID_COUNT(id)
#define TEXT_ID_BOOLEAN(id)
#define TEXT_ID_TEXT(id) TEXT_##id,
typedef enum {
#define VARIABLE(model, vr, kind, id, ...) IN_##model(TEXT_ID_##kind(id))
#include "variables.def"
    TEXT_COUNT
} TextId;

/* One more than the largest value reference of a variable that is no local. */
#define PLACE_PARAMETER(id, vr) char up_to_##id[vr + 1];
#define PLACE_INPUT PLACE_PARAMETER
#define PLACE_OUTPUT PLACE_PARAMETER
#define PLACE_LOCAL(id, vr)
#define PLACE_INDEPENDENT PLACE_LOCAL
typedef union {
#define VARIABLE(model, vr, kind, id, group, field, name, causality, ...) IN_##model(PLACE_##causality(id, vr))
#include "variables.def"
} StartPlaces;
enum { START_END = sizeof(StartPlaces) };

typedef struct {
    char mark[32];
    uint32_t size; /* bytes of the block */
    uint32_t number_count, text_count, text_size;
    char guid[GUID_SIZE];
    double number[START_END]; /* by value reference; of a text its TextId; NAN: no start value */
    char text[TEXT_COUNT][START_TEXT_SIZE];
} StartBlock;

typedef struct {
    char text[GUID_SIZE];
} Guid;

extern const Unit UNITS[UNIT_COUNT];
extern const Variable VARIABLES[REFERENCE_END]; /* by value reference; without a name where there is no variable */
extern const Limits LIMITS[START_END];          /* by value reference; locals are never set */

/* The unit guard that finds a present value strange, and that value; first, if the previous result is NULL, else the
 * next one. NULL: there is no other. Of one variable at most one guard is found. */
const UnitGuard *variables_strange(const Values *values, const UnitGuard *previous, double *value);

/* The variable with that value reference, or NULL. */
static inline const Variable *variable_find(unsigned reference) {
    return reference < REFERENCE_END && VARIABLES[reference].name != NULL ? &VARIABLES[reference] : NULL;
}

/* The Known of a tunable parameter, or -1. */
int tunable_known(unsigned reference);

/* The name of the type in this version of FMI: "Real", "Float64", ... */
const char *type_name(Type type);

/* The GUID in modelDescription.xml; in FMI 3.0 the instantiation token. */
Guid model_guid(void);

/* The start value of a parameter or input that is no text. */
double variable_start(unsigned reference);

/* Writes the start values of all parameters and inputs. All values are zero before. */
void variables_start(Values *values);

/* Is the value of a Real, Integer or Boolean, or the length of a String, in the range? */
bool variable_allows(const Variable *variable, double value);

typedef struct {
    char text[80];
} RangeText;

/* The values that variable_allows() accepts, in words. */
RangeText variable_range(const Variable *variable);

#endif
