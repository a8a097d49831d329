#include "numerics/jet.h"

#include <math.h>

#include "elementary/elementary.h"
#include "platform/attributes.h"

NOINLINE Jet jet_of_derivatives(const double u[JET_TERMS]) {
    Jet a = {.c = {{u[0], 0.0}}};
    double factorial = 1.0;
    for (int k = 1; k < JET_TERMS; k++) {
        factorial *= k;
        a.c[k].value = u[k] / factorial;
    }
    return a;
}

Jet jet_line(Dual offset, Dual factor, const Jet *a) {
    Jet line;
    for (int k = 0; k < JET_TERMS; k++) line.c[k] = dual_multiply(factor, a->c[k]);
    line.c[0] = dual_add(line.c[0], offset);
    return line;
}

void jet_add_product(Jet *sum, double factor, const Jet *a, const Jet *b) {
    for (int k = 0; k < JET_TERMS; k++)
        for (int j = 0; j <= k; j++)
            sum->c[k] = dual_add(sum->c[k], dual_scale(factor, dual_multiply(a->c[j], b->c[k - j])));
}

NOINLINE void jet_add_scaled(Jet *sum, double factor, const Jet *a) {
    for (int k = 0; k < JET_TERMS; k++) sum->c[k] = dual_add(sum->c[k], dual_scale(factor, a->c[k]));
}

Jet jet_multiply(const Jet *a, const Jet *b) {
    Jet product = {.c = {{0.0, 0.0}}}; /* a sum from 0 on is never the negative zero */
    for (int k = 0; k < JET_TERMS; k++) {
        for (int j = 0; j <= k; j++) product.c[k] = dual_add(product.c[k], dual_multiply(a->c[j], b->c[k - j]));
    }
    return product;
}

Jet jet_divide(const Jet *a, const Jet *b) {
    Jet quotient;
    for (int k = 0; k < JET_TERMS; k++) {
        Dual rest = a->c[k];
        for (int j = 1; j <= k; j++) rest = dual_add(rest, dual_scale(-1.0, dual_multiply(b->c[j], quotient.c[k - j])));
        const double value = rest.value / b->c[0].value;
        quotient.c[k] = (Dual){value, (rest.slope - value * b->c[0].slope) / b->c[0].value};
    }
    return quotient;
}

/* e = exp a: de/dt = e da/dt, so that k e_k = sum j a_j e_(k-j). */
Jet jet_exp(const Jet *a) {
    const double start = elementary_exp(a->c[0].value);
    Jet e = {.c = {{start, start * a->c[0].slope}}};
    for (int k = 1; k < JET_TERMS; k++)
        for (int j = 1; j <= k; j++)
            e.c[k] = dual_add(e.c[k], dual_scale((double)j / k, dual_multiply(a->c[j], e.c[k - j])));
    return e;
}

/* l = log a: a dl/dt = da/dt, so that l_k is the coefficient of the integral of (da/dt)/a. */
Jet jet_log(const Jet *a) {
    const Jet rate = jet_rate(a), quotient = jet_divide(&rate, a);
    Jet l = {.c = {{elementary_log(a->c[0].value), a->c[0].slope / a->c[0].value}}};
    for (int k = 1; k < JET_TERMS; k++) l.c[k] = dual_scale(1.0 / k, quotient.c[k - 1]);
    return l;
}

/* s s = a, so that 2 s_0 s_k = a_k less the products of the coefficients between. */
Jet jet_sqrt(const Jet *a) {
    const double start = sqrt(a->c[0].value);
    const Dual twice_inverse = {0.5 / start, -0.25 * a->c[0].slope / (start * a->c[0].value)};
    Jet s = {.c = {{start, 0.5 * a->c[0].slope / start}}};
    for (int k = 1; k < JET_TERMS; k++) {
        Dual rest = a->c[k];
        for (int j = 1; j < k; j++) rest = dual_add(rest, dual_scale(-1.0, dual_multiply(s.c[j], s.c[k - j])));
        s.c[k] = dual_multiply(rest, twice_inverse);
    }
    return s;
}

NOINLINE Jet jet_rate(const Jet *a) {
    Jet rate = {.c = {{0.0, 0.0}}};
    for (int k = 1; k < JET_TERMS; k++) rate.c[k - 1] = dual_scale(k, a->c[k]);
    return rate;
}

Jet jet_polynomial(const double *p, int degree, const Jet *x) {
    Jet sum = jet_line((Dual){p[degree - 1], 0.0}, (Dual){p[degree], 0.0}, x);
    for (int k = degree - 2; k >= 0; k--) {
        sum = jet_multiply(&sum, x);
        sum.c[0].value += p[k];
    }
    return sum;
}
