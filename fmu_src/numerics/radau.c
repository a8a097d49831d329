#include "numerics/radau.h"

#include "numerics/radau_table.h"

_Static_assert(RADAU_MAX <= (int)BERNSTEIN_MAX && RADAU_WIDTH <= BERNSTEIN_MAX + 1,
               "a Bernstein polynomial for every method");

const Radau *radau_of(int stages) {
    return stages <= 3 ? &RADAU_3 : (stages <= 5 ? &RADAU_5 : &RADAU_7);
}

Bernstein radau_polynomial(const Radau *method, const double value[RADAU_MAX + 1]) {
    Bernstein p = {.degree = method->stages};
    for (int j = 0; j <= method->stages; j++)
        for (int i = 0; i < RADAU_WIDTH; i++) p.c[i] += method->bernstein[j][i] * value[j];
    return p;
}
