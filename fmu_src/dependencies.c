#include "dependencies.h"

const Dependency DEPENDENCIES[] = {
#define UNIT(...)
#define VARIABLE(...)
#define FOLLOWS(model, unknown, known, kind) IN_##model({VR_##unknown, VR_##known, kind},)
#define STARTS_FROM(...)
#define RATE_OF(...)
#include "variables.def"
#undef UNIT
#undef VARIABLE
#undef FOLLOWS
#undef STARTS_FROM
#undef RATE_OF
    {VARIABLE_COUNT, VARIABLE_COUNT, DEPENDENT}};

const Dependency INITIAL_DEPENDENCIES[] = {
#define UNIT(...)
#define VARIABLE(...)
#define FOLLOWS(...)
#define STARTS_FROM(model, unknown, known, kind) IN_##model({VR_##unknown, VR_##known, kind},)
#define RATE_OF(...)
#include "variables.def"
#undef UNIT
#undef VARIABLE
#undef FOLLOWS
#undef STARTS_FROM
#undef RATE_OF
    {VARIABLE_COUNT, VARIABLE_COUNT, DEPENDENT}};

const Rate RATES[] = {
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
