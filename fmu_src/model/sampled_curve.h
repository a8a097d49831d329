/* The shape of a twice continuously differentiable curve through samples (x_j, y_j): quintic Hermite pieces without a
 * maximum or a minimum that the samples do not have. Grooves and friction tables are such curves.
 *
 * At each knot slope d_j and second derivative c_j are those of the polynomial of degree 4 through the 5 nearest knots
 * (j-2..j+2, shifted inward at the ends; with fewer knots through all). Then, with h_j the width of piece j, its chord
 * Delta_j = (y_{j+1}-y_j)/h_j and the sign s_j of the chord:
 *   (1) If a piece adjacent to knot j has Delta = 0, then d_j = c_j = 0. If the chords of both pieces differ in sign,
 *       then d_j = 0. Else s d_j = max(s d_j, 0).
 *   (2) clamp s c_j to at least -4 s d_j/h of the right piece and to at most 4 s d_j/h of the left piece.
 *   (3) for each piece e = 2 d0 + c0 h/4 + 2 d1 - c1 h/4; f = min(1, 5 Delta/e) (f = 1 if e has not the sign of Delta).
 *   (4) multiply d_j and c_j by the smallest f of the adjacent pieces.
 * Then the Bernstein coefficients of the derivative, d0, d0 + c0 h/4, 5 Delta - e, d1 - c1 h/4 and d1, all have the
 * sign of the chord (or are 0): each piece is monotone. */
#ifndef DUALCAM_SAMPLED_CURVE_H
#define DUALCAM_SAMPLED_CURVE_H

#include <stdbool.h>
#include <stddef.h>

/* x_j and y_j stand at x[j spacing] and y[j spacing]; x increases. */
typedef struct {
    const double *x, *y;
    size_t count, spacing; /* count >= 3 */
} CurveSamples;

/* Slope d and second derivative c at a sample. */
typedef struct {
    double slope, bend;
} CurveKnot;

/* Fills `knot`, which has space for samples->count. `level_end`: d = c = 0 at the last sample, where a constant
 * follows. */
void curve_knots(const CurveSamples *samples, bool level_end, CurveKnot *knot);

/* The greatest index k below `count` with x[k spacing] <= at; 0 where all are larger, or at is NaN. */
static inline size_t curve_interval(const double *x, size_t spacing, size_t count, double at) {
    size_t low = 0;
    while (count > 1) { /* at most 64 turns: `count` halves */
        const size_t half = count / 2;
        low = at >= x[(low + half) * spacing] ? low + half : low; /* without a branch: it cannot be predicted */
        count -= half;
    }
    return low;
}

static inline double curve_width(const CurveSamples *s, size_t j) {
    return s->x[(j + 1) * s->spacing] - s->x[j * s->spacing];
}

/* Delta_j */
static inline double curve_chord(const CurveSamples *s, size_t j) {
    return (s->y[(j + 1) * s->spacing] - s->y[j * s->spacing]) / curve_width(s, j);
}

/* e of step (3), of a piece of width h */
static inline double curve_end_sum(double h, CurveKnot a, CurveKnot b) {
    return 2.0 * a.slope + a.bend * h / 4.0 + 2.0 * b.slope - b.bend * h / 4.0;
}

#endif
