#include "model/friction_table.h"

#include <math.h>

#include "elementary/elementary.h"

/* ---- over the speed ---- */

/* The curve u_0 of one load, less ln mu where its piece starts, and its derivative by v. */
static Dual curve_at(const FrictionPiece *p, double v) {
    const Vector2 *c = p->c;
    const double t = (v - p->cell.lower) * p->per_width[0], x = t < -0.25 ? -0.25 : t;
    const double value = c[0][0] + x * (c[1][0] + x * (c[2][0] + x * (c[3][0] + x * c[4][0])));
    const double slope = c[0][0] + x * (2.0 * c[1][0] + x * (3.0 * c[2][0] + x * (4.0 * c[3][0] + x * 5.0 * c[4][0])));
    return (Dual){x * value, t < x ? 0.0 : slope * p->per_width[0]};
}

/* At the middle one of the loads. */
static FrictionCoefficient on_piece(const FrictionPiece *p, double v) {
    const Dual u = curve_at(p, v);
    const double value = p->mu[0] * elementary_exp(u.value);
    return (FrictionCoefficient){value, value * u.slope, 0.0};
}

/* ---- over speed and load ---- */

/* b of a patch, and its derivative by ln N. */
static Dual place_on(const FrictionPatch *patch, double N) {
    const double b = (elementary_log(max_of(N, DBL_MIN)) - patch->from[0]) * patch->per[0];
    const double inside = min_of(max_of(b, patch->low[0]), patch->high[0]);
    return (Dual){inside, b == inside ? patch->per[0] : 0.0};
}

static FrictionCoefficient on_patch(const FrictionPatch *patch, const FrictionPiece *piece, double v, double N) {
    const double t = max_of((v - piece->cell.lower) * piece->per_width[0], -0.25);
    const Dual b = place_on(patch, N);
    double u = 0.0, by_t = 0.0, by_b = 0.0;
    for (int m = 3; m >= 0; m--) {
        double value = patch->c[m][5][0], slope = 0.0;
        for (int n = 4; n >= 0; n--) {
            slope = slope * t + value;
            value = value * t + patch->c[m][n][0];
        }
        by_b = by_b * b.value + u;
        u = u * b.value + value;
        by_t = by_t * b.value + slope;
    }
    const double mu = elementary_exp(u);
    return (FrictionCoefficient){mu, mu * by_t * piece->per_width[0], N > 0.0 ? mu * by_b * b.slope / N : 0.0};
}

FrictionCoefficient friction_table_at(const FrictionTable *table, double v, double N) {
    const FrictionPiece *piece = friction_table_piece(table, v);
    if (table->loads == 1) return on_piece(piece, v);
    return on_patch(friction_table_patch(table, piece, friction_table_span(table, N)), piece, v, N);
}

/* b along a motion. */
static Jet place_along(const FrictionPatch *patch, double N, const Jet *load2) {
    const Dual at = place_on(patch, N), none = {0.0, 0.0};
    if (at.slope == 0.0) return (Jet){.c = {{at.value, 0.0}}};
    const Jet log_square = jet_log(load2);
    Jet b = jet_line(none, (Dual){0.5 * at.slope, 0.0}, &log_square);
    b.c[0].value = at.value;
    return b;
}

Jet friction_table_along(const FrictionTable *table, const Jet *v, const Jet *load2) {
    const FrictionPiece *piece = friction_table_piece(table, v->c[0].value);
    const double per_width = piece->per_width[0], N = sqrt(load2->c[0].value);
    const Jet t = jet_line((Dual){-piece->cell.lower * per_width, 0.0}, (Dual){per_width, 0.0}, v);
    if (table->loads == 1) {
        double c[6] = {piece->log_mu};
        for (int n = 0; n < 5; n++) c[n + 1] = piece->c[n][0];
        const Jet u = jet_polynomial(c, 5, &t);
        return jet_exp(&u);
    }
    const FrictionPatch *patch = friction_table_patch(table, piece, friction_table_span(table, N));
    const Jet b = place_along(patch, N, load2);
    Jet u = {.c = {{0.0, 0.0}}};
    for (int m = 3; m >= 0; m--) {
        double c[6];
        for (int n = 0; n < 6; n++) c[n] = patch->c[m][n][0];
        const Jet of_t = jet_polynomial(c, 5, &t);
        u = jet_multiply(&u, &b);
        jet_add_scaled(&u, 1.0, &of_t);
    }
    return jet_exp(&u);
}

/* ---- steps that end at samples ---- */

static double width_beside(const double *knot, size_t last, size_t k) {
    if (k == 0 || k > last) return INFINITY;
    const double below = knot[k] - knot[k - 1];
    return k < last ? min_of(below, knot[k + 1] - knot[k]) : below;
}

KnotCell friction_table_cell(const double *knot, size_t last, size_t k) {
    return (KnotCell){knot[k],
                      {k > 0 ? knot[k] : -INFINITY, k < last ? knot[k + 1] : INFINITY},
                      {width_beside(knot, last, k), width_beside(knot, last, k + 1)}};
}

static double share_of(const double *knot, size_t last, double overshoot, double from, double to) {
    const bool up = to > from;
    const Vector2 x = {from, from};
    size_t k = curve_interval(knot, 1, last + 1, from);
    for (;; k = up ? k + 1 : k - 1) { /* at most one turn per knot */
        const KnotCell cell = friction_table_cell(knot, last, k);
        const KnotSteps step = knot_steps(&cell, &cell, overshoot, x, up);
        if (knot_is_reached(&step, 0)) continue;
        const double change = fabs(to - from);
        return change <= step.longest[0] ? 1.0 : knot_aim(&step, 0) / change;
    }
}

double friction_table_share(const FrictionTable *table, double overshoot, double from, double to) {
    return share_of(table->speed, table->count, overshoot, from, to);
}

double friction_table_load_share(const FrictionTable *table, double overshoot, double from, double to) {
    return table->loads > 1 ? share_of(table->load, table->loads, overshoot, from, to) : 1.0;
}
