/* What depends on what, and what is the rate of what: the rows FOLLOWS, STARTS_FROM and RATE_OF of variables.def as
 * tables. Each ends with a row of VARIABLE_COUNT: no list may be empty in C. */
#ifndef DUALCAM_DEPENDENCIES_H
#define DUALCAM_DEPENDENCIES_H

#include "fmi/variables.h"

typedef enum { DEPENDENT, CONSTANT } DependencyKind;

typedef struct {
    uint8_t unknown, known; /* value references */
    uint8_t kind;           /* a DependencyKind */
} Dependency;

_Static_assert(VARIABLE_COUNT < UINT8_MAX, "value references fit");

typedef struct {
    uint8_t rate, state;
} Rate;

extern const Dependency DEPENDENCIES[];         /* of outputs, rates and event indicators */
extern const Dependency INITIAL_DEPENDENCIES[]; /* of start values */
extern const Rate RATES[];

#endif
