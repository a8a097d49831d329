/* Interpolation of fixed degree on [-1, 1] in Chebyshev points, and the monomials of the interpolant.
 *
 * Nodes are the extrema of T_N, both ends included, so that neighbouring interpolants meet (L. N. Trefethen,
 * Approximation Theory and Approximation Practice, chapters 3 and 4). */
#ifndef DUALCAM_CHEBYSHEV_H
#define DUALCAM_CHEBYSHEV_H

enum {
    CHEBYSHEV_DEGREE = 12,
    CHEBYSHEV_NODES = CHEBYSHEV_DEGREE + 1,
    CHEBYSHEV_CHECKS = CHEBYSHEV_DEGREE / 2, /* points between nodes, where an interpolant can be compared */
};

typedef struct {
    double node[CHEBYSHEV_NODES];                      /* rising from -1 to 1; the middle node is 0 */
    double weight[CHEBYSHEV_NODES][CHEBYSHEV_NODES];   /* c_k = sum_j weight[k][j] f(node[j]) */
    double monomial[CHEBYSHEV_NODES][CHEBYSHEV_NODES]; /* T_k = sum_m monomial[k][m] x^m */
    double check[CHEBYSHEV_CHECKS];
} ChebyshevBasis;

void chebyshev_build(ChebyshevBasis *basis);

/* The Chebyshev coefficients c of the polynomial with the values f at the nodes. */
void chebyshev_interpolate(const ChebyshevBasis *basis, const double f[CHEBYSHEV_NODES], double c[CHEBYSHEV_NODES]);

/* The coefficients of the same polynomial by powers of x, lowest first. */
void chebyshev_to_monomials(const ChebyshevBasis *basis, const double c[CHEBYSHEV_NODES], double out[CHEBYSHEV_NODES]);

#endif
