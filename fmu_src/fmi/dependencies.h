/* The model structure: the rows of dependencies.def as tables. Each table ends with a row of REFERENCE_END, since C
 * has no empty arrays. */
#ifndef DUALCAM_DEPENDENCIES_H
#define DUALCAM_DEPENDENCIES_H

#include "fmi/variables.h"

typedef enum { DEPENDENT, CONSTANT } DependencyKind;

typedef struct {
    uint8_t unknown, known; /* value references */
    uint8_t kind;           /* a DependencyKind */
} Dependency;

_Static_assert(REFERENCE_END < UINT8_MAX, "value references fit");

typedef struct {
    uint8_t derivative, state; /* value references */
} StateDerivative;

extern const Dependency DEPENDENCIES[];         /* of outputs, state derivatives and event indicators */
extern const Dependency INITIAL_DEPENDENCIES[]; /* of start values */
extern const StateDerivative STATE_DERIVATIVES[];

#endif
