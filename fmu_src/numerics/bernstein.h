/* Zeros and maxima of a polynomial on [0, 1] in Bernstein form: p(x) = sum c_i binom(n, i) x^i (1-x)^(n-i).
 *
 * The number of sign changes among the coefficients bounds the number of zeros (Descartes' rule in this basis). Halving
 * the interval sharpens the bound. A pair of close zeros is therefore never missed, as samples could miss them
 * (R. T. Farouki, Computer Aided Geometric Design 29, 2012). */
#ifndef DUALCAM_BERNSTEIN_H
#define DUALCAM_BERNSTEIN_H

#include <stdbool.h>

#include "numerics/tolerances.h"

enum { BERNSTEIN_MAX = 8 }; /* highest degree */

typedef struct {
    int degree;
    double c[BERNSTEIN_MAX + 1];
} Bernstein;

double bernstein_value(const Bernstein *p, double x);

/* True if the coefficients of p rise or fall throughout: then p does too. */
bool bernstein_is_monotone(const Bernstein *p);

/* The first x in [0, 1] at which p falls below zero, or infinity. The result is 0 if p(0) <= 0, unless p rises from
 * there. */
double bernstein_descent(const Bernstein *p);

/* Writes all x in (0, 1) at which p changes its sign, in order; returns their number. */
int bernstein_crossings(const Bernstein *p, double x[BERNSTEIN_MAX]);

Bernstein bernstein_derivative(const Bernstein *p); /* dp/dx; of a constant the constant 0 */

/* The x in [0, 1] at which |p| is largest, to BERNSTEIN_PEAK_WIDTH. */
double bernstein_peak(const Bernstein *p);

/* The polynomial u(t) = sum u_k t^k/k! of degree 3 on [0, t_end], as a polynomial in x = t/t_end. */
Bernstein bernstein_of_taylor(const double u[4], double t_end);

/* The polynomial u(t) = sum u_k t^k/k! of degree 3 starts in the strip |u| <= width. The sign with which u first leaves
 * the strip at a time t > 0, or 0 if u is constant. A polynomial that is not constant leaves every strip. */
int taylor_leaving_sign(const double u[4], double width);

#endif
