#include "model/friction_law.h"

#include <math.h>
#include <stddef.h>

#include "elementary/elementary.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

static double excess_of(const CamParams *cam) {
    return cam->friction * (cam->law.peak - 1.0); /* of the static coefficient */
}

/* m/s, above which the excess is below all rounding; -infinity without an excess. */
static double speed_without_excess(const CamParams *cam, double excess) {
    if (excess == 0.0) return -INFINITY;
    return cam->law.stribeck_velocity * (cam->law.stribeck_exponent == 2 ? STRIBECK_GONE_GAUSS : STRIBECK_GONE_TUSTIN);
}

/* The exponent -(v/v_s)^delta and its derivative by v/v_s. Tustin's law grows without bound for v < 0; the continuation
 * ends at v = -v_s. */
typedef struct {
    double value, slope;
} Exponent;

static Exponent stribeck_exponent(const FrictionParams *law, double ratio) {
    if (law->stribeck_exponent == 2) return (Exponent){-ratio * ratio, -2.0 * ratio};
    return ratio > -1.0 ? (Exponent){-ratio, -1.0} : (Exponent){1.0, 0.0};
}

FrictionCoefficient friction_at(const CamParams *cam, double v) {
    const FrictionParams *law = &cam->law;
    if (law->table) return friction_table_at(law->table, v);
    FrictionCoefficient mu = {cam->friction + law->viscous * v, law->viscous};
    const double excess = excess_of(cam);
    if (v > speed_without_excess(cam, excess)) return mu;
    const double per_speed = 1.0 / law->stribeck_velocity;
    const Exponent exponent = stribeck_exponent(law, v * per_speed);
    const double share = excess * elementary_exp(exponent.value);
    mu.value += share;
    mu.by_speed += share * exponent.slope * per_speed;
    return mu;
}

COMPACT LoadedFriction friction_under(const CamParams *cam, double v, double R) {
    const FrictionParams *law = &cam->law;
    if (law->table && law->table->loads > 1) return friction_table_under(law->table, v, R);
    const FrictionCoefficient mu = friction_at(cam, v);
    if (!friction_depends_on_load(cam)) return (LoadedFriction){mu.value, mu.by_speed, 0.0};
    const Dual log_ratio = level_log(R / law->load);
    const double power = elementary_exp(law->load_exponent * log_ratio.value);
    const double dry = (mu.value - law->viscous * v) * power;
    return (LoadedFriction){
        .value = dry + law->viscous * v,
        .by_speed = (mu.by_speed - law->viscous) * power + law->viscous,
        .by_load = law->load_exponent * dry * log_ratio.slope / law->load,
    };
}

NOINLINE VectorLoadPower friction_load_power(Vector2 exponent, Vector2 q) {
    const Vector2 none = {0.0, 0.0};
    if (q[0] >= LEVEL_LOG_FROM && q[1] >= LEVEL_LOG_FROM) {
        const Vector2 power = vector2_exp(exponent * vector2_log(q));
        return (VectorLoadPower){power, exponent * power, true};
    }
    VectorLoadPower out = {none, none, false};
    for (int j = 0; j < 2; j++) {
        const Dual l = level_log(q[j]);
        out.value[j] = elementary_exp(exponent[j] * l.value);
        out.by_log_load[j] = exponent[j] * l.slope * q[j] * out.value[j];
    }
    return out;
}

/* b at the load, before its limits, and its derivative by ln R. */
typedef struct {
    Vector2 b, per;
} LoadPlace;

NOINLINE static LoadPlace place_at(Vector2 from, Vector2 per, Vector2 q) {
    if (q[0] >= LEVEL_LOG_FROM && q[1] >= LEVEL_LOG_FROM) return (LoadPlace){(vector2_log(q) - from) * per, per};
    const Dual x = level_log(q[0]), y = level_log(q[1]);
    return (LoadPlace){((Vector2){x.value, y.value} - from) * per, q * (Vector2){x.slope, y.slope} * per};
}

NOINLINE static Vector2 exp_of(Vector2 u) {
    return vector2_exp(u);
}

/* Of the cubic u in b: ln mu, and its derivatives by ln R. */
ALWAYS_INLINE static inline VectorLoadedFriction cubic_at(const Vector2 u[4], Vector2 b, Vector2 per) {
    const Vector2 bent = 2.0 * u[2], steep = 3.0 * u[3];
    return (VectorLoadedFriction){
        .value = u[0] + b * (u[1] + b * (u[2] + b * u[3])),
        .power = (u[1] + b * (bent + b * steep)) * per,
        .bend = (bent + b * (steep + steep)) * per * per,
    };
}

/* ln mu at one speed, as a cubic in b. */
static inline void friction_cubic(const FrictionPatch *patch, const FrictionPiece *piece, double v, double u[4]) {
    const double t = (v - piece->cell.lower) * piece->per_width[0];
    for (int m = 0; m < 4; m++) {
        const Vector2 *c = patch->c[m];
        u[m] = c[5][0];
        for (int n = 4; n >= 0; n--) u[m] = u[m] * t + c[n][0];
    }
}

NOINLINE void friction_start(const FrictionPatch *const patch[2], const FrictionPiece *const piece[2],
                             const double v[2], const double q[2], FrictionStart *out) {
    const Vector2 from = {patch[0]->from[0], patch[1]->from[0]}, per = {patch[0]->per[0], patch[1]->per[0]};
    const Vector2 low = {patch[0]->low[0], patch[1]->low[0]}, high = {patch[0]->high[0], patch[1]->high[0]};
    double cubic[2][4];
    Vector2 u[4];
    for (int i = 0; i < 2; i++) friction_cubic(patch[i], piece[i], v[i], cubic[i]);
    for (int m = 0; m < 4; m++) u[m] = (Vector2){cubic[0][m], cubic[1][m]};
    const LoadPlace at = place_at(from, per, (Vector2){q[0], q[1]});
    out->b = vector2_min(vector2_max(at.b, low), high);
    out->above = high - 0.25 - out->b;
    out->below = low + 0.25 - out->b;
    out->per = at.per;
    out->mu = cubic_at(u, out->b, at.per);
    out->log_mu = out->mu.value;
    out->mu.value = exp_of(out->log_mu);
}

/* The load comes first: the compiler then reads the coefficients where they are used. */
VectorLoadedFriction friction_on_patch(const FrictionPatch *patch, const FrictionPiece *piece, const FrictionNear *near,
                                       Vector2 v, Vector2 R, bool with_slope) {
    const Vector2 ratio = (R - near->R) / (R + near->R);
    LoadPlace at = {near->b, patch->per};
    if (vector2_is_within(ratio, OF_TWO_LOG_NEAR)) at.b += patch->per * vector2_log_ratio(ratio);
    else at = place_at(patch->from, patch->per, R * near->per_load);
    const Vector2 b = vector2_min(vector2_max(at.b, patch->low), patch->high);
    const Vector2 t =
        vector2_min(vector2_max((v - piece->lower) * piece->per_width, (Vector2){-0.25, -0.25}), (Vector2){1.25, 1.25});
    Vector2 u[4], by_t = {0.0, 0.0}; /* u: of b^m */
    if (with_slope) {
        for (int m = 3; m >= 0; m--) {
            const Vector2 *c = patch->c[m];
            Vector2 slope = u[m] = c[5];
            for (int n = 4; n > 0; n--) {
                u[m] = u[m] * t + c[n];
                slope = slope * t + u[m];
            }
            u[m] = u[m] * t + c[0];
            by_t = by_t * b + slope;
        }
    } else {
        for (int m = 3; m >= 0; m--) {
            u[m] = patch->c[m][5];
            for (int n = 4; n >= 0; n--) u[m] = u[m] * t + patch->c[m][n];
        }
    }
    VectorLoadedFriction mu = cubic_at(u, b, at.per);
    const Vector2 change = mu.value - near->log_mu;
    mu.value = vector2_is_within(change, OF_TWO_EXP_SMALL) ? near->mu * vector2_exp_small(change) : exp_of(mu.value);
    if (with_slope) mu.by_speed = mu.value * by_t * piece->per_width;
    return mu;
}

/* FRICTION_OVERSHOOT tolerance^(3/8), by roots: nearly the third root. */
static double friction_overshoot(double tolerance) {
    const double quarter = sqrt(sqrt(tolerance));
    return FRICTION_OVERSHOOT * quarter * sqrt(quarter);
}

COMPACT static FrictionFall friction_fall(const CamParams *cam, double tolerance) {
    const FrictionParams *law = &cam->law;
    const double overshoot = friction_overshoot(tolerance);
    if (law->table) return (FrictionFall){.table = law->table, .overshoot = overshoot};
    FrictionFall fall = {.overshoot = overshoot, .end = -INFINITY};
    if (friction_depends_on_load(cam)) fall.level = LEVEL_LOG_FROM * law->load;
    if (excess_of(cam) == 0.0) return fall;
    const bool gauss = law->stribeck_exponent == 2, tight = tolerance < STRIBECK_TIGHT;
    const double fallen = tight ? STRIBECK_FALLEN_TIGHT : STRIBECK_FALLEN;
    fall.end = law->stribeck_velocity * (gauss ? sqrt(fallen) : fallen);
    fall.span = law->stribeck_velocity * (gauss ? STRIBECK_SPAN_GAUSS : STRIBECK_SPAN_TUSTIN);
    return fall;
}

static bool has_loads(const FrictionTable *table) {
    return table != NULL && table->loads > 1;
}

static FrictionSource source_of(const Params *p) {
    const FrictionTable *a = p->cam[0].law.table, *b = p->cam[1].law.table;
    if (!a && !b) return FRICTION_BY_LAWS;
    if (has_loads(a) && has_loads(b)) return FRICTION_ON_PATCHES;
    return has_loads(a) || has_loads(b) ? FRICTION_ON_PATCH : FRICTION_ON_PIECES;
}

COMPACT static FrictionNearby nearby_of(const Params *p, int i, double sign) {
    const CamParams *cam = &p->cam[i];
    const FrictionParams *law = &cam->law;
    const Vector2 none = {0.0, 0.0};
    const double excess = excess_of(cam);
    return (FrictionNearby){
        .kinetic = none + sign * cam->friction,
        .viscous = none + (law->table ? 0.0 : sign * law->viscous),
        .excess = none + sign * excess,
        .minus_by_v = none - 1.0 / law->stribeck_velocity,
        .per_load = none + 1.0 / (p->contacts * (has_loads(law->table) ? law->table->load[1] : law->load)),
        .load_exponent = none + (friction_depends_on_load(cam) && !law->table ? law->load_exponent : 0.0),
        .radius = none + cam->radius,
        .radius2 = none + cam->radius * cam->radius,
        .gone = speed_without_excess(cam, excess),
        .sign = none + sign,
        .is_gauss = law->stribeck_exponent == 2,
        .has_table = law->table != NULL,
        .has_patches = has_loads(law->table),
        .source = source_of(p),
    };
}

COMPACT void friction_prepare(const Params *params, int i, FrictionConstants *constants) {
    constants->fall = friction_fall(&params->cam[i], params->tolerance);
    constants->tabled = params->cam[i].law.table ? i : 1 - i;
    constants->table = params->cam[constants->tabled].law.table;
    const FrictionTable *own = params->cam[i].law.table;
    constants->loaded = has_loads(own) ? own : NULL;
    for (int sign = -1; sign <= 1; sign += 2) constants->near[friction_sign_index(sign)] = nearby_of(params, i, sign);
}

/* ---- jets ---- */

static Dual seeded(double value, Known known, Known first, int i) {
    return (Dual){value, (int)known == (int)first + i ? 1.0 : 0.0};
}

static Dual inverse_of(Dual a) {
    return (Dual){1.0 / a.value, -a.slope / (a.value * a.value)};
}

/* exp(-(v/v_s)^delta) */
COMPACT static Jet stribeck_along(const FrictionParams *law, int i, const Jet *v, Known known) {
    const Dual v_s = seeded(law->stribeck_velocity, known, KNOWN_STRIBECK_VELOCITY_1, i), none = {0.0, 0.0};
    const Jet ratio = jet_line(none, inverse_of(v_s), v);
    const Jet power = law->stribeck_exponent == 2 ? jet_multiply(&ratio, &ratio) : ratio;
    const Jet exponent = jet_line(none, (Dual){-1.0, 0.0}, &power);
    return jet_exp(&exponent);
}

/* (R/R_ref)^nu */
COMPACT static Jet load_power_along(const FrictionParams *law, int i, const Jet *R, Known known) {
    const Dual load = seeded(law->load, known, KNOWN_LOAD_1, i), none = {0.0, 0.0};
    const Dual exponent = seeded(law->load_exponent, known, KNOWN_LOAD_EXPONENT_1, i);
    const Jet ratio = jet_line(none, inverse_of(load), R);
    const Jet log_ratio = level_log_along(&ratio), power = jet_line(none, exponent, &log_ratio);
    return jet_exp(&power);
}

COMPACT Jet friction_along(const CamParams *cam, int i, const Jet *v, const Jet *R, Known known) {
    const FrictionParams *law = &cam->law;
    if (law->table) return friction_table_along(law->table, v, R);
    const Dual kinetic = seeded(cam->friction, known, KNOWN_FRICTION_1, i), none = {0.0, 0.0};
    const Dual peak = seeded(law->peak, known, KNOWN_PEAK_1, i);
    const Dual viscous = seeded(law->viscous, known, KNOWN_VISCOUS_1, i);
    const Dual excess = dual_multiply(kinetic, dual_line(-1.0, 1.0, peak));
    Jet mu = {.c = {kinetic}};
    if (excess.value != 0.0 || excess.slope != 0.0) {
        const Jet stribeck = stribeck_along(law, i, v, known), share = jet_line(none, excess, &stribeck);
        jet_add_scaled(&mu, 1.0, &share);
    }
    if (R != NULL && (friction_depends_on_load(cam) || (int)known == (int)KNOWN_LOAD_EXPONENT_1 + i)) {
        const Jet power = load_power_along(law, i, R, known);
        mu = jet_multiply(&mu, &power);
    }
    const Jet lubricated = jet_line(none, viscous, v);
    jet_add_scaled(&mu, 1.0, &lubricated);
    return mu;
}
