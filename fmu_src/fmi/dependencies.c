#include "fmi/dependencies.h"

const Dependency DEPENDENCIES[] = {
#define DEPENDENCY(model, unknown, known, kind) IN_##model({VR_##unknown, VR_##known, kind}, )
#include "fmi/dependencies.def"
    {REFERENCE_END, REFERENCE_END, DEPENDENT}};

const Dependency INITIAL_DEPENDENCIES[] = {
#define INITIAL_DEPENDENCY(model, unknown, known, kind) IN_##model({VR_##unknown, VR_##known, kind}, )
#include "fmi/dependencies.def"
    {REFERENCE_END, REFERENCE_END, DEPENDENT}};

const StateDerivative STATE_DERIVATIVES[] = {
#define STATE_DERIVATIVE(model, derivative, state) IN_##model({VR_##derivative, VR_##state}, )
#include "fmi/dependencies.def"
    {REFERENCE_END, REFERENCE_END}};
