/* Coefficients of Lobatto IIIA collocation with four nodes, order 6 at the end of the step, and arithmetic on four
 * values, one per node.
 *
 * The nodes are 0, (5 - sqrt 5)/10, (5 + sqrt 5)/10 and 1: the first one is the start of the step, the last one its
 * end. The cubic P through the values y_j of a derivative at the nodes stands for that derivative over the step
 * (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section IV.5). Two values share a vector
 * register. One piece of code serves both halves, at half the size of code for all four values in a row. */
#ifndef DUALCAM_LOBATTO_H
#define DUALCAM_LOBATTO_H

#include <math.h>
#include <stdbool.h>

#include "elementary/elementary.h"
#include "elementary/vector2.h"
#include "numerics/bernstein.h"

enum { LOBATTO_NODES = 4, LOBATTO_END = LOBATTO_NODES - 1, LOBATTO_HALVES = 2 };

typedef union {
    double at[LOBATTO_NODES];
    Vector2 half[LOBATTO_HALVES];
} LobattoValues;

typedef struct {
    LobattoValues node;
    LobattoValues once[LOBATTO_NODES];  /* [j]: integrals up to each node of the cubic that is 1 at node j, else 0 */
    LobattoValues twice[LOBATTO_NODES]; /* [j]: the same of its integral */
    LobattoValues weight;               /* the integral over the step is h sum_j weight[j] y_j */
    double missed;                      /* at the start, of c^3: c^3 less the parabola through the last three nodes */
    double missed_once, missed_twice;   /* largest single and double integral of prod(1 - c/c_i), i > 0: the shape of
                                         * the error of that parabola */
    LobattoValues bernstein[LOBATTO_NODES]; /* [j]: Bernstein coefficients of the cubic that is 1 at node j, else 0 */
} Lobatto;

#include "numerics/lobatto_table.h"

static inline LobattoValues lobatto_constant(double x) {
    return (LobattoValues){{x, x, x, x}};
}

/* sum_j column[j] y_j, for each node */
static inline LobattoValues lobatto_combine(const LobattoValues column[LOBATTO_NODES], const LobattoValues *y) {
    LobattoValues sum;
    for (int k = 0; k < LOBATTO_HALVES; k++)
        sum.half[k] = (column[0].half[k] * y->at[0] + column[1].half[k] * y->at[1]) +
                      (column[2].half[k] * y->at[2] + column[3].half[k] * y->at[3]);
    return sum;
}

typedef struct {
    double low, high;
} LobattoRange;

static inline LobattoRange lobatto_range(const LobattoValues *v) {
    const double *x = v->at;
    const double low[2] = {x[2] < x[0] ? x[2] : x[0], x[3] < x[1] ? x[3] : x[1]};
    const double high[2] = {x[2] > x[0] ? x[2] : x[0], x[3] > x[1] ? x[3] : x[1]};
    return (LobattoRange){low[1] < low[0] ? low[1] : low[0], high[1] > high[0] ? high[1] : high[0]};
}

/* The largest |value| of a range. */
static inline double lobatto_largest(LobattoRange r) {
    return max_of(r.high, -r.low);
}

/* True if `sign` times the cubic through the values stays above zero over the whole step. */
static inline bool lobatto_keeps_sign(const LobattoValues *v, int sign) {
    const LobattoRange r = lobatto_range(v);
    const double low = sign > 0 ? r.low : -r.high;
    return low > BEYOND_NODES * (r.high - r.low);
}

static inline double lobatto_sum(Vector2 v) {
    return v[0] + v[1];
}

/* A parabola over the step: at the share c of the step start + c (linear + c square). */
typedef struct {
    double start, linear, square;
} Parabola;

static inline Parabola parabola_through(double start, Vector2 middle_and_end) {
    const double m = middle_and_end[0] - start, e = middle_and_end[1] - start;
    return (Parabola){start, 4.0 * m - e, 2.0 * (e - 2.0 * m)};
}

static inline Vector2 parabola_at(const Parabola *p, Vector2 c) {
    return p->start + c * (p->linear + c * p->square);
}

/* Integral and double integral from the start on, per length of the step and per its square. */
static inline Vector2 parabola_once(const Parabola *p, Vector2 c) {
    return c * (p->start + c * (0.5 * p->linear + c * (p->square * (1.0 / 3.0))));
}

static inline Vector2 parabola_twice(const Parabola *p, Vector2 c) {
    return c * c * (0.5 * p->start + c * (p->linear * (1.0 / 6.0) + c * (p->square * (1.0 / 12.0))));
}

#endif
