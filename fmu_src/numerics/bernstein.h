/* Zeros and maxima of a polynomial on [0, 1] in Bernstein form: p(x) = sum c_i binom(n, i) x^i (1-x)^(n-i).
 *
 * The coefficients' signs bound the number of zeros (Descartes' rule in this basis), and halving the interval
 * sharpens the bound, so that a pair of close zeros is not stepped over as samples would (G. Farouki,
 * Computer Aided Geometric Design 29, 2012). */
#ifndef DUALCAM_BERNSTEIN_H
#define DUALCAM_BERNSTEIN_H

#include <stdbool.h>

enum { BERNSTEIN_MAX = 8 }; /* highest degree */

typedef struct {
    int degree;
    double c[BERNSTEIN_MAX + 1];
} Bernstein;

/* A polynomial through its values at the start and the nodes of a collocation method leaves their range by less than
 * this share of its width: the Lebesgue constants of those nodes are below 2.2. */
static const double BEYOND_NODES = 0.6;

double bernstein_value(const Bernstein *p, double x);

/* True if p surely rises or falls throughout: its coefficients do. */
bool bernstein_is_monotone(const Bernstein *p);

/* First x in (0, 1] at which p falls below zero, or infinity. A p that is not positive at 0 falls at 0, unless
 * it rises there. */
double bernstein_descent(const Bernstein *p);

/* All x in (0, 1) at which p changes its sign, in order; returns how many. */
int bernstein_crossings(const Bernstein *p, double x[BERNSTEIN_MAX]);

Bernstein bernstein_derivative(const Bernstein *p); /* by x; of a constant the constant 0 */

/* The x in [0, 1] at which |p| is largest, to about 1e-9. */
double bernstein_peak(const Bernstein *p);

/* p of degree <= 3 given by its derivatives at 0, u(t) = sum u_k t^k/k!, on [0, t_end]. */
Bernstein bernstein_of_taylor(const double u[4], double t_end);

#endif
