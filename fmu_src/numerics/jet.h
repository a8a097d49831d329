/* Jets: truncated Taylor polynomials in time, f(t) = sum c_k t^k, so that the k-th time derivative of f is k! c_k. Each
 * coefficient is a dual number, which adds the derivative by one known. The arithmetic is exact up to rounding
 * (A. Griewank, A. Walther, Evaluating Derivatives, 2nd ed., chapter 13.) */
#ifndef DUALCAM_JET_H
#define DUALCAM_JET_H

#include "elementary/elementary.h"
#include "numerics/dual.h"

enum { JET_TERMS = 4 };

typedef struct {
    Dual c[JET_TERMS];
} Jet;

/* The function whose value and derivatives at t = 0 are u. */
Jet jet_of_derivatives(const double u[JET_TERMS]);

/* offset + factor a */
Jet jet_line(Dual offset, Dual factor, const Jet *a);

/* sum += factor a b, sum += factor a */
void jet_add_product(Jet *sum, double factor, const Jet *a, const Jet *b);
void jet_add_scaled(Jet *sum, double factor, const Jet *a);

Jet jet_multiply(const Jet *a, const Jet *b);
Jet jet_divide(const Jet *a, const Jet *b);

Jet jet_exp(const Jet *a);

/* a(0) > 0 */
Jet jet_log(const Jet *a);

/* a(0) > 0 */
Jet jet_sqrt(const Jet *a);

/* da/dt; the last coefficient, which a does not determine, is left 0. */
Jet jet_rate(const Jet *a);

/* p[0] + p[1] x + ... + p[degree] x^degree, degree >= 1 */
Jet jet_polynomial(const double *p, int degree, const Jet *x);

#endif
