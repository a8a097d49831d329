#include "fmi/dependencies.h"

const Dependency DEPENDENCIES[] = {
#define FOLLOWS(model, unknown, known, kind) IN_##model({VR_##unknown, VR_##known, kind}, )
#include "variables.def"
    {VARIABLE_COUNT, VARIABLE_COUNT, DEPENDENT}};

const Dependency INITIAL_DEPENDENCIES[] = {
#define STARTS_FROM(model, unknown, known, kind) IN_##model({VR_##unknown, VR_##known, kind}, )
#include "variables.def"
    {VARIABLE_COUNT, VARIABLE_COUNT, DEPENDENT}};

const Rate RATES[] = {
#define RATE_OF(model, rate, state) IN_##model({VR_##rate, VR_##state}, )
#include "variables.def"
    {VARIABLE_COUNT, VARIABLE_COUNT}};
