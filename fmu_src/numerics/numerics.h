/* The numerics room holds arithmetic and methods that know nothing of cams: compensated sums, dual numbers, Taylor
 * jets, Bernstein polynomials, Chebyshev interpolation, root finding, golden section search, quadrature and the tables
 * of the collocation methods. It may include platform only.
 *
 * This header holds the type of functions of one variable, and the tolerances and limits of the numerical methods.
 * model/tolerances.h holds the tolerances of all other rooms. */
#ifndef DUALCAM_NUMERICS_H
#define DUALCAM_NUMERICS_H

#include <float.h>

/* f(x); `context` holds all other arguments. */
typedef double ScalarFunction(const void *context, double x);

/* ---- bernstein ---- */

/* Halvings of [0, 1] at most: 2^-48 is 16 roundings of 1, and narrower intervals hold nothing. */
enum { BERNSTEIN_MAX_DEPTH = 48 };

/* Width, as a share of [0, 1], to which a zero of a polynomial is found: some roundings. */
static const double BERNSTEIN_ZERO_WIDTH = 1e-15;

/* Width, as a share of [0, 1], to which a maximum is found: the value there errs by the square of this share. */
static const double BERNSTEIN_PEAK_WIDTH = 1e-10;

/* Steps of bisection and regula falsi at most; bisection alone needs 50. */
enum { BERNSTEIN_MAX_ITERATIONS = 100 };

/* A polynomial through its values at the start and at the nodes of a collocation method exceeds the range of these
 * values by less than this share of the range: the Lebesgue constants of the nodes are below 2.2. */
static const double BEYOND_NODES = 0.6;

/* ---- root ---- */

/* Iterations at most; the method takes at most three times those of bisection, which are 64 for all doubles. */
enum { ROOT_MAX_ITERATIONS = 200 };

/* Share of |x| at which a bracket holds no double between its ends. */
static const double ROOT_WIDTH = 2.0 * DBL_EPSILON;

/* ---- quadrature ---- */

/* Halvings of a panel, and panels in all, at most: they bound the work whatever the integrand is. */
enum { QUADRATURE_MAX_DEPTH = 40, QUADRATURE_MAX_PANELS = 20000 };

/* Golden sections in the search for a peak: 0.618^40 = 4e-9 of the interval, and the value errs by the square. */
enum { QUADRATURE_PEAK_STEPS = 40 };

/* Panels below this share of the interval are not divided where formulas change: where two formulas nearly agree,
 * rounding may change them often. */
static const double QUADRATURE_NARROW = 1e-6;

/* A panel is integrated to the tolerance times this share of the whole sum of magnitudes at least. */
static const double QUADRATURE_NEGLIGIBLE = 1e-3;

/* Share of a panel's sum of magnitudes that rounding may take. */
static const double QUADRATURE_ROUNDING = 16.0 * DBL_EPSILON;

/* A sample exceeds its neighbours, and is searched for a peak, by more than this share of its value: rounding. */
static const double QUADRATURE_PEAK_ROUNDING = 4.0 * DBL_EPSILON;

#endif
