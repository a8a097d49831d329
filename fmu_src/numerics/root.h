/* The zero of a function between two points where its signs differ.
 *
 * The room numerics/ holds arithmetic and methods that know nothing of cams: compensated sums, dual numbers, Taylor
 * jets, Bernstein polynomials, Chebyshev interpolation, root finding, golden section search, quadrature, the tables of
 * the collocation methods; and tolerances.h, which all rooms share. May include: platform, elementary. */
#ifndef DUALCAM_ROOT_H
#define DUALCAM_ROOT_H

/* f(x); `context` holds all other arguments. */
typedef double ScalarFunction(const void *context, double x);

/* The zero to rounding: no double lies between the x returned and a change of sign. The values f_a and f_b at a and b
 * differ in sign, or one of them is zero; they may be infinite. */
double root_between(ScalarFunction *f, const void *context, double a, double f_a, double b, double f_b);

#endif
