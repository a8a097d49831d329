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

/* The coefficient without the lubricated branch and the load, and its derivative by the speed. */
static Dual dry_friction(const CamParams *cam, double v) {
    const double excess = excess_of(cam), per_speed = 1.0 / cam->law.stribeck_velocity;
    if (v > speed_without_excess(cam, excess)) return (Dual){cam->friction, 0.0};
    const Exponent exponent = stribeck_exponent(&cam->law, v * per_speed);
    const double share = excess * elementary_exp(exponent.value);
    return (Dual){cam->friction + share, share * exponent.slope * per_speed};
}

FrictionCoefficient friction_at(const CamParams *cam, double v, double N) {
    const FrictionParams *law = &cam->law;
    if (law->table) return friction_table_at(law->table, v, N);
    const Dual dry = dry_friction(cam, v);
    double power = 1.0, by_load = 0.0;
    if (friction_depends_on_load(cam)) {
        const double q = N / law->load, square = q * q + NOMINAL_LOAD_LOW * NOMINAL_LOAD_LOW;
        power = elementary_exp(0.5 * law->load_exponent * elementary_log(square));
        by_load = law->load_exponent * q / (square * law->load);
    }
    return (FrictionCoefficient){
        .value = dry.value * power + law->viscous * v,
        .by_speed = dry.slope * power + law->viscous,
        .by_load = dry.value * power * by_load,
    };
}

NOINLINE VectorFriction friction_on_patch(Vector2 sign, const FrictionPatch *patch, const FrictionPiece *piece,
                                          Vector2 v, Vector2 load2) {
    const Vector2 least = {DBL_MIN, DBL_MIN}; /* no load: beyond the first one */
    const Vector2 b =
        vector2_min(vector2_max((0.5 * vector2_log(vector2_max(load2, least)) - patch->from) * patch->per, patch->low),
                    patch->high);
    const Vector2 t =
        vector2_min(vector2_max((v - piece->lower) * piece->per_width, (Vector2){-0.25, -0.25}), (Vector2){1.25, 1.25});
    Vector2 u = {0.0, 0.0}, by_t = {0.0, 0.0};
    for (int m = 3; m >= 0; m--) {
        const Vector2 *c = patch->c[m];
        Vector2 value = c[5], slope = value;
        for (int n = 4; n > 0; n--) {
            value = value * t + c[n];
            slope = slope * t + value;
        }
        u = u * b + (value * t + c[0]);
        by_t = by_t * b + slope;
    }
    const Vector2 mu = sign * vector2_exp(u);
    return (VectorFriction){mu, mu * by_t * piece->per_width};
}

/* FRICTION_OVERSHOOT tolerance^(3/8), by roots: nearly the third root. */
static double friction_overshoot(double tolerance) {
    const double quarter = sqrt(sqrt(tolerance));
    return FRICTION_OVERSHOOT * quarter * sqrt(quarter);
}

static FrictionFall friction_fall(const CamParams *cam, double tolerance) {
    const FrictionParams *law = &cam->law;
    const double overshoot = friction_overshoot(tolerance);
    if (law->table) return (FrictionFall){.table = law->table, .overshoot = overshoot};
    FrictionFall fall = {.overshoot = overshoot, .end = -INFINITY};
    if (friction_depends_on_load(cam)) fall.low = NOMINAL_LOAD_LOW * law->load;
    if (excess_of(cam) == 0.0) return fall;
    const bool gauss = law->stribeck_exponent == 2, tight = tolerance < STRIBECK_TIGHT;
    const double fallen = tight ? STRIBECK_FALLEN_TIGHT : STRIBECK_FALLEN;
    fall.end = law->stribeck_velocity * (gauss ? sqrt(fallen) : fallen);
    fall.span = law->stribeck_velocity * (gauss ? STRIBECK_SPAN_GAUSS : STRIBECK_SPAN_TUSTIN);
    return fall;
}

static FrictionNearby nearby_of(const Params *p, int i, double sign) {
    const CamParams *cam = &p->cam[i];
    const FrictionParams *law = &cam->law;
    const Vector2 none = {0.0, 0.0};
    const double excess = excess_of(cam);
    const double per_load = 1.0 / (p->contacts * cam->radius * (law->table ? 1.0 : law->load));
    const double half_exponent = friction_depends_on_load(cam) && !law->table ? 0.5 * law->load_exponent : 0.0;
    FrictionNearby near = {
        .kinetic = none + sign * cam->friction,
        .viscous = none + (law->table ? 0.0 : sign * law->viscous),
        .excess = none + sign * excess,
        .minus_by_v = none - 1.0 / law->stribeck_velocity,
        .per_load2 = none + per_load * per_load,
        .half_exponent = none + half_exponent,
        .radius = none + cam->radius,
        .radius2 = none + cam->radius * cam->radius,
        .gone = speed_without_excess(cam, excess),
        .sign = none + sign,
        .is_gauss = law->stribeck_exponent == 2,
        .has_table = law->table != NULL,
    };
    double binomial = 1.0;
    for (int k = 0; k < 6; k++) near.binomial[k] = none + (binomial *= (half_exponent - k) / (k + 1.0));
    return near;
}

void friction_prepare(const Params *params, int i, FrictionConstants *constants) {
    constants->fall = friction_fall(&params->cam[i], params->tolerance);
    constants->tabled = params->cam[i].law.table ? i : 1 - i;
    constants->table = params->cam[constants->tabled].law.table;
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
static Jet stribeck_along(const FrictionParams *law, int i, const Jet *v, Known known) {
    const Dual v_s = seeded(law->stribeck_velocity, known, KNOWN_STRIBECK_VELOCITY_1, i), none = {0.0, 0.0};
    const Jet ratio = jet_line(none, inverse_of(v_s), v);
    const Jet power = law->stribeck_exponent == 2 ? jet_multiply(&ratio, &ratio) : ratio;
    const Jet exponent = jet_line(none, (Dual){-1.0, 0.0}, &power);
    return jet_exp(&exponent);
}

/* ((N^2 + N_0^2)/N_ref^2)^(nu/2) */
static Jet load_power_along(const FrictionParams *law, int i, const Jet *load2, Known known) {
    const Dual per_load = inverse_of(seeded(law->load, known, KNOWN_LOAD_1, i)), none = {0.0, 0.0};
    const Dual exponent = dual_scale(0.5, seeded(law->load_exponent, known, KNOWN_LOAD_EXPONENT_1, i));
    const Jet square =
        jet_line((Dual){NOMINAL_LOAD_LOW * NOMINAL_LOAD_LOW, 0.0}, dual_multiply(per_load, per_load), load2);
    const Jet log_square = jet_log(&square), power = jet_line(none, exponent, &log_square);
    return jet_exp(&power);
}

Jet friction_along(const CamParams *cam, int i, const Jet *v, const Jet *load2, Known known) {
    const FrictionParams *law = &cam->law;
    if (law->table) return friction_table_along(law->table, v, load2);
    const Dual kinetic = seeded(cam->friction, known, KNOWN_FRICTION_1, i), none = {0.0, 0.0};
    const Dual peak = seeded(law->peak, known, KNOWN_PEAK_1, i);
    const Dual viscous = seeded(law->viscous, known, KNOWN_VISCOUS_1, i);
    const Dual excess = dual_multiply(kinetic, dual_line(-1.0, 1.0, peak));
    Jet mu = {.c = {kinetic}};
    if (excess.value != 0.0 || excess.slope != 0.0) {
        const Jet stribeck = stribeck_along(law, i, v, known), share = jet_line(none, excess, &stribeck);
        jet_add_scaled(&mu, 1.0, &share);
    }
    if (friction_depends_on_load(cam) || (int)known == (int)KNOWN_LOAD_EXPONENT_1 + i) {
        const Jet power = load_power_along(law, i, load2, known);
        mu = jet_multiply(&mu, &power);
    }
    const Jet lubricated = jet_line(none, viscous, v);
    jet_add_scaled(&mu, 1.0, &lubricated);
    return mu;
}
