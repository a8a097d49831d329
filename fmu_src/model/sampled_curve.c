#include "model/sampled_curve.h"

#include "elementary/elementary.h"
#include "numerics/sign.h"

enum { STENCIL = 5 }; /* samples in the difference formula */

/* First and second derivative, at x[0], of the polynomial through n points, by Newton's divided differences. */
static CurveKnot polynomial_derivatives(int n, const double x[STENCIL], const double y[STENCIL]) {
    double difference[STENCIL] = {0.0}; /* [k]: divided difference of the points 0..k */
    for (int k = 0; k < n; k++) difference[k] = y[k];
    for (int k = 1; k < n; k++)
        for (int i = n - 1; i >= k; i--) difference[i] = (difference[i] - difference[i - 1]) / (x[i] - x[i - k]);
    /* p'(x0) and p''(x0)/2 of the basis polynomial (x - x0)...(x - x_{k-1}) */
    double first = 1.0, half_second = 0.0;
    CurveKnot knot = {difference[1], 0.0};
    for (int k = 2; k < n; k++) {
        half_second = half_second * (x[0] - x[k - 1]) + first;
        first *= x[0] - x[k - 1];
        knot.slope += difference[k] * first;
        knot.bend += 2.0 * difference[k] * half_second;
    }
    return knot;
}

/* Sample j first, then the other ones of its stencil. */
static CurveKnot estimate(const CurveSamples *s, size_t j) {
    const size_t n = s->count < STENCIL ? s->count : STENCIL;
    size_t begin = j < 2 ? 0 : j - 2;
    if (begin > s->count - n) begin = s->count - n;
    double x[STENCIL] = {s->x[j * s->spacing]}, y[STENCIL] = {s->y[j * s->spacing]};
    int used = 1;
    for (size_t i = begin; i < begin + n; i++) {
        if (i == j) continue;
        x[used] = s->x[i * s->spacing];
        y[used++] = s->y[i * s->spacing];
    }
    return polynomial_derivatives((int)n, x, y);
}

/* Steps (1) and (2) of the rule in the header. */
static CurveKnot bounded(const CurveSamples *s, size_t j, CurveKnot knot) {
    const bool left = j > 0, right = j + 1 < s->count;
    const int s_left = left ? sign_of(curve_chord(s, j - 1)) : sign_of(curve_chord(s, j));
    const int s_right = right ? sign_of(curve_chord(s, j)) : s_left;
    if (s_left == 0 || s_right == 0) return (CurveKnot){0.0, 0.0};
    knot.slope = s_left == s_right ? s_right * max_of(s_right * knot.slope, 0.0) : 0.0;
    if (right) knot.bend = s_right * max_of(s_right * knot.bend, -4.0 * (s_right * knot.slope) / curve_width(s, j));
    if (left) knot.bend = s_left * min_of(s_left * knot.bend, 4.0 * (s_left * knot.slope) / curve_width(s, j - 1));
    return knot;
}

/* f of step (3) */
static double shrink(const CurveSamples *s, size_t j, const CurveKnot *knot) {
    const double chord = curve_chord(s, j), sum = curve_end_sum(curve_width(s, j), knot[j], knot[j + 1]);
    return sign_of(sum) != 0 && sign_of(sum) == sign_of(chord) ? min_of(1.0, 5.0 * chord / sum) : 1.0;
}

/* Step (4). The factors belong to the knots before step (4): the factor of the left piece is computed before its right
 * knot changes. */
static void shrink_all(const CurveSamples *s, CurveKnot *knot) {
    double left = 1.0;
    for (size_t j = 0; j < s->count; j++) {
        const double right = j + 1 < s->count ? shrink(s, j, knot) : 1.0;
        const double f = min_of(left, right);
        knot[j].slope *= f;
        knot[j].bend *= f;
        left = right;
    }
}

void curve_knots(const CurveSamples *s, bool level_end, CurveKnot *knot) {
    for (size_t j = 0; j < s->count; j++) knot[j] = bounded(s, j, estimate(s, j));
    if (level_end) knot[s->count - 1] = (CurveKnot){0.0, 0.0};
    shrink_all(s, knot);
}
