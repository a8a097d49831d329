#include "model/friction_table.h"

#include <math.h>

#include "elementary/elementary.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* ---- over the speed ---- */

/* The curve u_k, less ln mu where its piece starts, and its derivative by v. */
static FrictionCoefficient curve_at(const FrictionPiece *p, double v) {
    const Vector2 *c = p->c;
    const double t = (v - p->cell.lower) * p->per_width[0], x = t < -0.25 ? -0.25 : t;
    const double value = c[0][0] + x * (c[1][0] + x * (c[2][0] + x * (c[3][0] + x * c[4][0])));
    const double slope = c[0][0] + x * (2.0 * c[1][0] + x * (3.0 * c[2][0] + x * (4.0 * c[3][0] + x * 5.0 * c[4][0])));
    return (FrictionCoefficient){x * value, t < x ? 0.0 : slope * p->per_width[0]};
}

static const FrictionPiece *piece_of(const FrictionTable *table, size_t load, size_t j) {
    return &table->piece[load * (table->count + 1) + j];
}

FrictionCoefficient friction_table_at(const FrictionTable *table, double v) {
    const FrictionPiece *p = friction_table_piece(table, v);
    const FrictionCoefficient u = curve_at(p, v);
    const double value = p->mu[0] * elementary_exp(u.value);
    return (FrictionCoefficient){value, value * u.by_speed};
}

/* u_k(v) along a motion. */
COMPACT static Jet curve_along(const FrictionTable *table, size_t k, const Jet *v) {
    const FrictionPiece *p = piece_of(table, k, friction_table_sample(table, v->c[0].value));
    double c[6] = {p->log_mu};
    for (int n = 0; n < 5; n++) c[n + 1] = p->c[n][0];
    const double per_width = p->per_width[0];
    const Jet t = jet_line((Dual){-p->cell.lower * per_width, 0.0}, (Dual){per_width, 0.0}, v);
    return jet_polynomial(c, 5, &t);
}

/* ---- over the load ---- */

/* The spline at ln R: weights of the values at the loads k and k + 1 and of the second derivatives there. */
typedef struct {
    size_t k;
    double a, h; /* (x_{k+1} - x)/h, h = x_{k+1} - x_k */
} SplinePlace;

COMPACT static SplinePlace place_of(const FrictionTable *table, double x) {
    const size_t k = friction_table_find(table->log_load, 0, table->loads - 1, x);
    const double h = table->log_load[k + 1] - table->log_load[k];
    return (SplinePlace){k, (table->log_load[k + 1] - x) / h, h};
}

/* Value and slope over ln R of the spline through u[k]. Beyond the loads a straight line continues the spline. */
COMPACT static FrictionCoefficient spline_at(const FrictionTable *table, const SplinePlace *at, const double u[]) {
    const double h = at->h, a = min_of(max_of(at->a, 0.0), 1.0), b = 1.0 - a;
    double bend[2] = {0.0, 0.0};
    for (size_t l = 0; l < table->loads; l++)
        for (size_t end = 0; end < 2; end++) bend[end] += table->bend[at->k + end][l] * u[l];
    const double *y = &u[at->k];
    const double slope = (y[1] - y[0]) / h + ((1.0 - 3.0 * a * a) * bend[0] + (3.0 * b * b - 1.0) * bend[1]) * h / 6.0;
    const double value = a * y[0] + b * y[1] + ((a * a * a - a) * bend[0] + (b * b * b - b) * bend[1]) * h * h / 6.0;
    return (FrictionCoefficient){value + slope * h * (a - at->a), slope};
}

COMPACT LoadedFriction friction_table_under(const FrictionTable *table, double v, double R) {
    const Dual log_ratio = level_log(R / table->load[1]);
    const SplinePlace at = place_of(table, table->log_load[0] + log_ratio.value);
    const size_t j = friction_table_sample(table, v);
    double u[FRICTION_LOADS_MAX], slope[FRICTION_LOADS_MAX];
    for (size_t k = 0; k < table->loads; k++) {
        const FrictionPiece *p = piece_of(table, k, j);
        const FrictionCoefficient curve = curve_at(p, v);
        u[k] = p->log_mu + curve.value;
        slope[k] = curve.by_speed;
    }
    const FrictionCoefficient spline = spline_at(table, &at, u);
    const double mu = elementary_exp(spline.value);
    return (LoadedFriction){mu, mu * spline_at(table, &at, slope).value,
                            mu * spline.by_speed * log_ratio.slope / table->load[1]};
}

/* The same as spline_at(), of jets. `x`: ln R. */
COMPACT static Jet spline_along(const FrictionTable *table, const Jet u[], const Jet *x) {
    const SplinePlace at = place_of(table, x->c[0].value);
    const double inner = min_of(max_of(at.a, 0.0), 1.0), h = at.h;
    Jet bend[2] = {{.c = {{0.0, 0.0}}}, {.c = {{0.0, 0.0}}}};
    for (size_t l = 0; l < table->loads; l++)
        for (size_t end = 0; end < 2; end++) jet_add_scaled(&bend[end], table->bend[at.k + end][l], &u[l]);
    Jet share = jet_line((Dual){-table->log_load[at.k] / h, 0.0}, (Dual){1.0 / h, 0.0}, x); /* b */
    const Jet beyond = jet_line((Dual){(inner - 1.0), 0.0}, (Dual){1.0, 0.0}, &share);
    if (inner != at.a) share = (Jet){.c = {{1.0 - inner, 0.0}}};
    const double a_powers[] = {0.0, -2.0, 3.0, -1.0}, b_powers[] = {0.0, -1.0, 0.0, 1.0}; /* a^3 - a, b^3 - b */
    Jet rise = u[at.k + 1], value = u[at.k];
    jet_add_scaled(&rise, -1.0, &u[at.k]);
    const Jet a_term = jet_polynomial(a_powers, 3, &share), b_term = jet_polynomial(b_powers, 3, &share);
    jet_add_product(&value, 1.0, &share, &rise);
    jet_add_product(&value, h * h / 6.0, &a_term, &bend[0]);
    jet_add_product(&value, h * h / 6.0, &b_term, &bend[1]);
    if (inner == at.a) return value;
    const double a = inner, b = 1.0 - inner; /* at an end of the loads */
    jet_add_scaled(&rise, (1.0 - 3.0 * a * a) * h * h / 6.0, &bend[0]);
    jet_add_scaled(&rise, (3.0 * b * b - 1.0) * h * h / 6.0, &bend[1]);
    jet_add_product(&value, 1.0, &beyond, &rise);
    return value;
}

COMPACT Jet friction_table_along(const FrictionTable *table, const Jet *v, const Jet *R) {
    Jet u[FRICTION_LOADS_MAX];
    for (size_t k = 0; k < table->loads; k++) u[k] = curve_along(table, k, v);
    if (table->loads == 1) return jet_exp(&u[0]);
    const Dual none = {0.0, 0.0};
    const Jet ratio = jet_line(none, (Dual){1.0 / table->load[1], 0.0}, R);
    Jet x = level_log_along(&ratio);
    x.c[0].value += table->log_load[0];
    const Jet log_mu = spline_along(table, u, &x);
    return jet_exp(&log_mu);
}

/* ---- steps ---- */

static double width_beside(const double *knot, size_t last, size_t k) {
    if (k == 0 || k > last) return INFINITY;
    const double below = knot[k] - knot[k - 1];
    return k < last ? min_of(below, knot[k + 1] - knot[k]) : below;
}

COMPACT KnotCell friction_table_cell(const double *knot, size_t last, size_t k) {
    return (KnotCell){knot[k],
                      {k > 0 ? knot[k] : -INFINITY, k < last ? knot[k + 1] : INFINITY},
                      {width_beside(knot, last, k), width_beside(knot, last, k + 1)}};
}

COMPACT static double share_of(const double *knot, size_t last, double overshoot, double from, double to) {
    const bool up = to > from;
    const Vector2 x = {from, from};
    size_t k = friction_table_find(knot, 0, last + 1, from);
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

double friction_level_share(double level, double overshoot, double from, double to) {
    const double knot[2] = {0.0, level};
    return share_of(knot, 1, overshoot, from, to);
}
