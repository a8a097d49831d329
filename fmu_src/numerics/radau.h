/* Coefficients of Radau IIA collocation with 3, 5 and 7 stages, order 2s - 1 at the end of the step.
 *
 * The polynomial P through the values y_j of a derivative at the nodes c_j h stands for that derivative over the step.
 * The integrals of P up to node i are h sum_j once[j][i] y_j and h^2 sum_j twice[j][i] y_j. The method is A- and
 * L-stable. The last node is the end of the step (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II,
 * section IV.5). */
#ifndef DUALCAM_RADAU_H
#define DUALCAM_RADAU_H

#include "numerics/bernstein.h"

enum { RADAU_MIN = 3, RADAU_MAX = 7 }; /* stages */
enum { RADAU_WIDTH = 8 };              /* entries of a column: zeros fill it up, so that loops have a fixed length */

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

/* sum a_j b_j over n nodes */
static inline double radau_dot(const double a[RADAU_MAX], const double b[RADAU_MAX], int n) {
    double sum = 0.0;
    for (int j = 0; j < n; j++) sum += a[j] * b[j];
    return sum;
}

/* sum_j columns[j][i] y_j for i < width. `width` is a constant where this is inlined, so that the loops have a fixed
 * length. */
static inline void radau_combine_to(int width, const double columns[RADAU_MAX][RADAU_WIDTH], const double y[RADAU_MAX],
                                    int n, double out[RADAU_WIDTH]) {
    for (int i = 0; i < width; i++) out[i] = 0.0;
    for (int j = 0; j < n; j++)
        for (int i = 0; i < width; i++) out[i] += columns[j][i] * y[j];
}

/* sum_j columns[j][i] y_j for every node i: with the columns of a method the integrals of y up to the n nodes. Three
 * stages need half the width. */
static inline void radau_combine(const double columns[RADAU_MAX][RADAU_WIDTH], const double y[RADAU_MAX], int n,
                                 double out[RADAU_WIDTH]) {
    if (n <= RADAU_WIDTH / 2) {
        radau_combine_to(RADAU_WIDTH / 2, columns, y, n, out);
    } else {
        radau_combine_to(RADAU_WIDTH, columns, y, n, out);
    }
}

/* Values of a quantity at the start of a step (index 0) and at its nodes, and their range. */
typedef struct {
    double value[RADAU_MAX + 1];
    double low, high;
} RadauValues;

static inline void radau_find_range(RadauValues *v, int stages) {
    v->low = v->high = v->value[0];
    for (int j = 1; j <= stages; j++) {
        v->low = v->value[j] < v->low ? v->value[j] : v->low;
        v->high = v->value[j] > v->high ? v->value[j] : v->high;
    }
}

#endif
