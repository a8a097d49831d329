#include "radau.h"

#include "radau_table.h"

_Static_assert(RADAU_MAX <= (int)BERNSTEIN_MAX, "a Bernstein polynomial for every method");

const Radau *radau_of(int stages) {
    return stages <= 3 ? &RADAU_3 : (stages <= 5 ? &RADAU_5 : &RADAU_7);
}

Bernstein radau_polynomial(const Radau *method, const double value[RADAU_MAX + 1]) {
    Bernstein p = {.degree = method->stages};
    for (int i = 0; i <= method->stages; i++)
        for (int j = 0; j <= method->stages; j++) p.c[i] += method->bernstein[i][j] * value[j];
    return p;
}
