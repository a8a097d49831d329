#include "geometry/groove_table.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "numerics/tolerances.h"
#include "platform/attributes.h"

enum { STENCIL = 5 }; /* samples in the difference formula */

/* Slope d and second derivative c at a sample. */
typedef struct {
    double slope, dslope_dpsi;
} Knot;

static double width_at(const Samples *s, size_t j) {
    return s->sample[j + 1].psi - s->sample[j].psi;
}

/* Delta_j */
static double chord(const Samples *s, size_t j) {
    return (s->sample[j + 1].z - s->sample[j].z) / width_at(s, j);
}

/* First and second derivative, at x[0], of the polynomial through n points (4 or 5), by Newton's
 * divided differences. */
static Knot polynomial_derivatives(int n, const double x[STENCIL], const double y[STENCIL]) {
    double difference[STENCIL] = {0.0}; /* [k]: divided difference of the points 0..k */
    for (int k = 0; k < n; k++) difference[k] = y[k];
    for (int k = 1; k < n; k++)
        for (int i = n - 1; i >= k; i--) difference[i] = (difference[i] - difference[i - 1]) / (x[i] - x[i - k]);
    /* p'(x0) and p''(x0)/2 of the basis polynomial (x - x0)...(x - x_{k-1}) */
    double first = 1.0, half_second = 0.0;
    Knot knot = {difference[1], 0.0};
    for (int k = 2; k < n; k++) {
        half_second = half_second * (x[0] - x[k - 1]) + first;
        first *= x[0] - x[k - 1];
        knot.slope += difference[k] * first;
        knot.dslope_dpsi += 2.0 * difference[k] * half_second;
    }
    return knot;
}

/* Sample j first, then the other ones of its stencil. */
static Knot estimate(const Samples *s, size_t j) {
    const size_t n = s->count < STENCIL ? s->count : STENCIL;
    size_t begin = j < 2 ? 0 : j - 2;
    if (begin > s->count - n) begin = s->count - n;
    double x[STENCIL] = {s->sample[j].psi}, y[STENCIL] = {s->sample[j].z};
    int used = 1;
    for (size_t i = begin; i < begin + n; i++) {
        if (i == j) continue;
        x[used] = s->sample[i].psi;
        y[used++] = s->sample[i].z;
    }
    return polynomial_derivatives((int)n, x, y);
}

/* Steps (1) and (2) of the rule in the header. */
static Knot bounded(const Samples *s, size_t j, Knot knot) {
    const bool left = j > 0, right = j + 1 < s->count;
    const bool dwell = (left && chord(s, j - 1) == 0.0) || (right && chord(s, j) == 0.0);
    if (dwell) return (Knot){0.0, 0.0};
    knot.slope = fmax(knot.slope, 0.0);
    if (right) knot.dslope_dpsi = fmax(knot.dslope_dpsi, -4.0 * knot.slope / width_at(s, j));
    if (left) knot.dslope_dpsi = fmin(knot.dslope_dpsi, 4.0 * knot.slope / width_at(s, j - 1));
    return knot;
}

/* s of step (3) */
static double end_sum(double h, Knot a, Knot b) {
    return 2.0 * a.slope + a.dslope_dpsi * h / 4.0 + 2.0 * b.slope - b.dslope_dpsi * h / 4.0;
}

/* f of step (3) */
static double shrink(const Samples *s, size_t j, const Knot *knot) {
    const double sum = end_sum(width_at(s, j), knot[j], knot[j + 1]);
    return sum > 0.0 ? fmin(1.0, 5.0 * chord(s, j) / sum) : 1.0;
}

/* Step (4). The factors belong to the knots before step (4): the factor of the left piece is computed before its right
 * knot changes. */
static void shrink_all(const Samples *s, Knot *knot) {
    double left = 1.0;
    for (size_t j = 0; j < s->count; j++) {
        const double right = j + 1 < s->count ? shrink(s, j, knot) : 1.0;
        const double f = fmin(left, right);
        knot[j].slope *= f;
        knot[j].dslope_dpsi *= f;
        left = right;
    }
}

static TablePiece piece_of(const Samples *s, size_t j, const Knot *knot) {
    const double h = width_at(s, j);
    const Knot a = knot[j], b = knot[j + 1];
    /* each coefficient is >= 0 by the rule; fmax removes its rounding */
    return (TablePiece){
        .psi = s->sample[j].psi,
        .width = h,
        .z = s->sample[j].z,
        .slope = {a.slope, fmax(a.slope + a.dslope_dpsi * h / 4.0, 0.0),
                  fmax(5.0 * chord(s, j) - end_sum(h, a, b), 0.0), fmax(b.slope - b.dslope_dpsi * h / 4.0, 0.0),
                  b.slope},
    };
}

static bool is_finite_piece(const TablePiece *p) {
    double sum = p->width + p->z;
    for (int k = 0; k < 5; k++) sum += p->slope[k];
    return isfinite(sum) && isfinite(4.0 * sum / p->width);
}

static const TablePiece *find(const Table *table, double psi) {
    size_t low = 0, high = table->count; /* piece[low].psi <= psi < piece[high].psi */
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (psi >= table->piece[middle].psi) low = middle;
        else high = middle;
    }
    return &table->piece[low];
}

/* The rise since the start of the piece, and derivatives, at the share t of its width. Slope and rise are sums of terms
 * >= 0: they do not cancel, and the slope is not negative. */
static GroovePoint piece_value(const TablePiece *p, double t) {
    const double *b = p->slope;
    const double u = 1.0 - t, tt = t * t, uu = u * u, ut = u * t;
    const double slope = uu * (uu * b[0] + 4.0 * ut * b[1]) + 6.0 * ut * ut * b[2] + tt * (4.0 * ut * b[3] + tt * b[4]);
    const double dslope_dpsi = 4.0 * (uu * u * (b[1] - b[0]) + 3.0 * ut * u * (b[2] - b[1]) +
                                      3.0 * ut * t * (b[3] - b[2]) + tt * t * (b[4] - b[3]));
    const double s1 = b[0], s2 = s1 + b[1], s3 = s2 + b[2], s4 = s3 + b[3], s5 = s4 + b[4];
    const double rise =
        t * (uu * (5.0 * uu * s1 + 10.0 * ut * s2) + tt * (10.0 * uu * s3 + 5.0 * ut * s4 + tt * s5)) / 5.0;
    return (GroovePoint){rise * p->width, slope, dslope_dpsi / p->width};
}

/* Makes z exactly 0 at psi = 0. */
static void shift_to_origin(Table *table) {
    const TablePiece *home = find(table, 0.0);
    const double offset = home->z, rise = piece_value(home, -home->psi / home->width).z;
    for (size_t j = 0; j < table->count; j++) table->piece[j].z = (table->piece[j].z - offset) - rise;
}

static bool fill(Table *table, const Samples *samples, Knot *knot) {
    for (size_t j = 0; j < samples->count; j++) knot[j] = bounded(samples, j, estimate(samples, j));
    shrink_all(samples, knot);
    for (size_t j = 0; j < table->count; j++) {
        table->piece[j] = piece_of(samples, j, knot);
        if (!is_finite_piece(&table->piece[j])) return false;
    }
    shift_to_origin(table);
    return true;
}

COMPACT bool table_build(Table *table, const Samples *samples) {
    Knot *knot = malloc(samples->count * sizeof *knot);
    *table = (Table){.piece = malloc((samples->count - 1) * sizeof(TablePiece)), .count = samples->count - 1};
    const bool good = knot && table->piece && fill(table, samples, knot);
    free(knot);
    if (!good) table_free(table);
    return good;
}

void table_free(Table *table) {
    free(table->piece);
    *table = (Table){.piece = NULL};
}

GroovePoint table_at(const Table *table, double psi) {
    const TablePiece *p = find(table, psi);
    GroovePoint point = piece_value(p, (psi - p->psi) / p->width);
    point.z += p->z;
    return point;
}

static const TablePiece *find_height(const Table *table, double z) {
    size_t low = 0, high = table->count;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (z >= table->piece[middle].z) low = middle;
        else high = middle;
    }
    return &table->piece[low];
}

/* Newton's method inside a bracket, with bisection where the curve is too flat for Newton's method. */
double table_angle(const Table *table, double z) {
    const TablePiece *p = find_height(table, z);
    double low = 0.0, high = 1.0, t = 0.5;
    for (int i = 0; i < TABLE_MAX_ITERATIONS; i++) {
        const GroovePoint point = piece_value(p, t);
        const double excess = p->z + point.z - z;
        if (excess == 0.0) break;
        if (excess < 0.0) low = t;
        else high = t;
        double next = t - excess / (point.slope * p->width);
        if (!(next > low && next < high)) next = low + 0.5 * (high - low);
        if (fabs(next - t) <= TABLE_ROUNDING) break;
        t = next;
    }
    return p->psi + t * p->width;
}
