/* The unit of time of the benchmarks: one exp and one sincos of the machine's libm. Both functions come in as
 * pointers, so that neither the compiler nor the linker can hoist, merge or vectorise their calls. Every loop calls
 * all of them alike. */
#ifndef UNIT_H
#define UNIT_H

#include <stddef.h>

#include "clock.h"

typedef double Exp(double x);
typedef void Sincos(double x, double *sine, double *cosine);

/* Seconds for n times one exp and one sincos. The arguments come from memory and the results are summed, so no call
 * waits for another one. */
EXPORT double seconds_plain(Exp *exp_, Sincos *sincos_, const double x[], size_t n, double *sum) {
    const double start = now();
    double total = 0.0;
    for (size_t i = 0; i < n; i++) {
        double sine, cosine;
        sincos_(x[i], &sine, &cosine);
        total += exp_(-x[i]) + sine + cosine;
    }
    *sum = total;
    return now() - start;
}

#endif
