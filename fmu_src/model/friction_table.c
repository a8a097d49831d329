#include "model/friction_table.h"

#include <math.h>

#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* The piece that holds v < table->end; the first one for v < 0. */
static const FrictionPiece *find(const FrictionTable *table, double v) {
    size_t low = 0, high = table->count; /* piece[low].v <= v < piece[high].v */
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (v >= table->piece[middle].v) low = middle;
        else high = middle;
    }
    return &table->piece[low];
}

FrictionCoefficient friction_table_at(const FrictionTable *table, double v) {
    if (v >= table->end) return (FrictionCoefficient){table->at_end, 0.0};
    const FrictionPiece *p = find(table, v);
    const double t = (v - p->v) * p->per_width, x = t < -0.25 ? -0.25 : t, *c = p->c;
    const double value = p->mu * exp(x * (c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * c[4])))));
    const double slope = c[0] + x * (2.0 * c[1] + x * (3.0 * c[2] + x * (4.0 * c[3] + x * 5.0 * c[4])));
    return (FrictionCoefficient){value, t < x ? 0.0 : value * slope * p->per_width};
}

COMPACT Jet friction_table_along(const FrictionTable *table, const Jet *v) {
    const Dual none = {0.0, 0.0};
    if (v->c[0].value >= table->end) return jet_line((Dual){table->at_end, 0.0}, none, v);
    const FrictionPiece *p = find(table, v->c[0].value);
    const double c[6] = {0.0, p->c[0], p->c[1], p->c[2], p->c[3], p->c[4]};
    const Jet t = jet_line((Dual){-p->v * p->per_width, 0.0}, (Dual){p->per_width, 0.0}, v);
    const Jet exponent = jet_polynomial(c, 5, &t), growth = jet_exp(&exponent);
    return jet_line(none, (Dual){p->mu, 0.0}, &growth);
}

/* m/s: the speed of sample k */
static double speed_of(const FrictionTable *table, size_t k) {
    return k < table->count ? table->piece[k].v : table->end;
}

/* m/s: of the piece that ends at sample k */
static double width_below(const FrictionTable *table, size_t k) {
    return speed_of(table, k) - speed_of(table, k - 1);
}

/* The step ahead ends at the next sample, or after a part of the piece. A step aims at the middle of the overshoot; a
 * step that starts close to a sample has reached that sample before. */
COMPACT double friction_table_share(const FrictionTable *table, double overshoot, double v, double to) {
    const bool up = to > v;
    const size_t n = table->count;
    size_t k = v < table->end ? (size_t)(find(table, v) - table->piece) : n; /* sample k is at or below v */
    for (k += up; up ? k <= n : k > 0; k += up ? 1 : (size_t)-1) {
        const double knot = speed_of(table, k), below = width_below(table, k);
        const double above = k < n ? width_below(table, k + 1) : INFINITY;
        const double beyond = overshoot * fmin(below, above), distance = up ? knot - v : v - knot;
        if (distance < 0.25 * beyond) continue;
        const double change = fabs(to - v), part = FRICTION_SPAN * (up ? below : above);
        if (part < distance) return change <= part ? 1.0 : STEP_SAFETY * part / change;
        return change <= distance + beyond ? 1.0 : (distance + 0.5 * beyond) / change;
    }
    return 1.0;
}
