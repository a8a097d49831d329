/* Coefficients of Radau IIA collocation with 3, 5 and 7 stages, order 2s - 1 at the end of the step.
 *
 * A polynomial P through the values y_j of a derivative at the nodes c_j h stands for it over the step. Then its
 * integrals up to node i are h sum_j once[j][i] y_j and h^2 sum_j twice[j][i] y_j. The method is A- and L-stable and
 * the last node is the end of the step (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.5). */
#ifndef DUALCAM_RADAU_H
#define DUALCAM_RADAU_H

#include "numerics/bernstein.h"

enum { RADAU_MIN = 3, RADAU_MAX = 7 }; /* stages */
enum { RADAU_WIDTH = 8 };              /* of a column: zeros fill it up, so that loops over it have a fixed length */

typedef struct {
    int stages;
    double node[RADAU_MAX];
    double once[RADAU_MAX][RADAU_WIDTH], twice[RADAU_MAX][RADAU_WIDTH];
    double weight[RADAU_MAX];   /* the integral over the step is h sum_j weight[j] y_j */
    double at_start[RADAU_MAX]; /* P(0) = sum at_start[j] y_j */
    /* largest single and double integral over [0, 1] of prod(1 - c/c_i), the shape of the error of P */
    double defect_once, defect_twice;
    /* [j][i]: Bernstein coefficient i of the polynomial of degree s that is 1 at node j - 1 (j = 0: at 0), else 0 */
    double bernstein[RADAU_MAX + 1][RADAU_WIDTH];
} Radau;

/* The method with at least `stages` stages: 3, 5 or 7. */
const Radau *radau_of(int stages);

/* The polynomial through value[0] at 0 and value[1 + j] at node j. */
Bernstein radau_polynomial(const Radau *method, const double value[RADAU_MAX + 1]);

#endif
