#include "contact/domain.h"

#include <math.h>
#include <stdio.h>

#include "contact/contact.h"
#include "contact/contact_factors.h"
#include "contact/slip_mode.h"
#include "elementary/elementary.h"
#include "model/elements.h"
#include "model/friction_law.h"
#include "numerics/tolerances.h"

/* ---- the determinant ---- */

/* What resists a motion in one direction: J, m, I; or b, c, 0; or Delta alone. */
typedef struct {
    double shaft, follower, turning;
} Resistance;

/* D at the signed friction coefficients f. */
typedef struct {
    const Params *params;
    double f[2];
    Resistance by;
} Determinant;

/* Quadratic damping alone resists as soon as there is a speed: any positive coefficient tells its sign. */
static Resistance resistance_of(const Params *p, int direction) {
    const InertiaParams *in = &p->inertia;
    if (has_inertia(p)) return (Resistance){in->shaft, in->follower_mass, in->follower};
    if (slip_regime(p, direction) == REGIME_RATE_INDEPENDENT) return (Resistance){1.0, 0.0, 0.0};
    const double c = direction > 0 ? p->damper.c_load : p->damper.c_release;
    const double q = direction > 0 ? p->damper.q_load : p->damper.q_release;
    return (Resistance){p->shaft.damping, c > 0.0 ? c : q, 0.0};
}

/* The resistance at any speed: quadratic damping outgrows the rest. */
static Resistance resistance_at_speed(const Params *p, int direction) {
    Resistance by = resistance_of(p, direction);
    const bool is_quadratic = (direction > 0 ? p->damper.q_load : p->damper.q_release) > 0.0;
    if (!has_inertia(p) && is_quadratic) by = (Resistance){0.0, 1.0, 0.0};
    return by;
}

static ContactFactors factors_at(const Determinant *d, const double slope[2]) {
    ContactFactors f;
    for (int i = 0; i < 2; i++) contact_factors_set(&f, i, d->params->cam[i].radius, d->f[i], slope[i]);
    contact_factors_multiply(&f);
    return f;
}

static double determinant_at(const Determinant *d, const double slope[2]) {
    const ContactFactors f = factors_at(d, slope);
    const double dgamma_dtheta = slope[1] / (slope[0] + slope[1]);
    return d->by.shaft * f.delta + d->by.follower * slope[0] * dgamma_dtheta * f.p +
           d->by.turning * dgamma_dtheta * f.q;
}

/* ---- bounds ---- */

/* A lower bound of D while the slopes stay between `low` and `high`. Delta, P and Q are bilinear in the slopes: each is
 * least at a corner. z' grows with both slopes, gamma' with that of cam 2 alone. */
static double determinant_bound(const Determinant *d, const double low[2], const double high[2]) {
    double delta = INFINITY, p = INFINITY, q = INFINITY;
    for (int corner = 0; corner < 4; corner++) {
        const double slope[2] = {corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1]};
        const ContactFactors f = factors_at(d, slope);
        delta = min_of(delta, f.delta);
        p = min_of(p, f.p);
        q = min_of(q, f.q);
    }
    const double least_lift = low[0] + low[1] > 0.0 ? cam_dz_dtheta(low) : 0.0;
    const double dz_dtheta = p < 0.0 ? cam_dz_dtheta(high) : least_lift;
    const double dgamma_dtheta = q < 0.0 ? high[1] / (high[1] + low[0]) : low[1] / (low[1] + high[0]);
    return d->by.shaft * delta + d->by.follower * dz_dtheta * p + d->by.turning * dgamma_dtheta * q;
}

/* m: how far a slope of the piece goes from its value in the middle of an interval of x of this half width: the
 * derivative is at most the sum of k |c_k|. */
static double slope_reach(const TransmissionPiece *piece, int i, double half) {
    double steepness = 0.0;
    for (int k = 1; k <= TRANSMISSION_DEGREE; k++) steepness += k * fabs(piece->slope[k][i]);
    return half * steepness;
}

/* Is D > 0 for x between middle - half and middle + half? Halves the interval until the bound shows it. */
static bool is_positive_between(const Determinant *d, const TransmissionPiece *piece, double middle, double half,
                                int *halvings) {
    const TransmissionPoint point = piece_at(piece, piece->middle + middle / piece->scale);
    double slope[2], low[2], high[2];
    for (int i = 0; i < 2; i++) {
        const double reach = slope_reach(piece, i, half);
        slope[i] = max_of(point.slope[i], 0.0);
        low[i] = max_of(slope[i] - reach, 0.0);
        high[i] = slope[i] + reach;
    }
    if (!(determinant_at(d, slope) > 0.0)) return false;
    if (determinant_bound(d, low, high) > 0.0) return true;
    if (--*halvings < 0) return false;
    return is_positive_between(d, piece, middle - 0.5 * half, 0.5 * half, halvings) &&
           is_positive_between(d, piece, middle + 0.5 * half, 0.5 * half, halvings);
}

static bool is_positive(const Determinant *d, const Transmission *transmission) {
    const TransmissionPiece *piece = transmission->piece;
    if (transmission->straight) {
        const double slope[2] = {piece->slope[0][0], piece->slope[0][1]};
        return determinant_at(d, slope) > 0.0;
    }
    for (size_t n = 0; n < transmission->count; n++) {
        int halvings = DOMAIN_HALVINGS;
        if (!is_positive_between(d, &piece[n], 0.0, 1.0, &halvings)) return false;
    }
    return true;
}

/* ---- friction ---- */

/* Places between the stops. Helices have the same slopes everywhere: one place tells all, unless friction depends on
 * the load. */
typedef struct {
    const Transmission *transmission;
    int intervals; /* of a piece, between its samples */
    size_t next;
    double theta;
    TransmissionPoint point;
} Sampler;

static Sampler sampler_of(const Params *p, const Transmission *transmission) {
    Sampler s = {.transmission = transmission};
    if (!transmission->straight || any_friction_depends_on_load(p))
        s.intervals = transmission->count < JAM_MANY_PIECES ? JAM_SAMPLES : JAM_SAMPLES_OF_MANY;
    return s;
}

/* Goes on to the next place; false after the last one. */
static bool next_sample(Sampler *s) {
    const size_t places = (size_t)s->intervals + 1, n = s->next++;
    if (n >= places * s->transmission->count) return false;
    const TransmissionPiece *piece = &s->transmission->piece[n / places];
    const int sample = (int)(n % places);
    if (sample == 0) s->theta = piece->lower;
    else if (sample == s->intervals) s->theta = piece->upper;
    else s->theta = piece->lower + (piece->upper - piece->lower) * sample / s->intervals;
    s->point = piece_at(piece, s->theta);
    return true;
}

/* The largest coefficients at rest between the stops, under F_ext. */
static void largest_friction(const Params *p, const Transmission *transmission, double F_ext, double mu[2]) {
    for (int i = 0; i < 2; i++) {
        const FrictionTable *table = p->cam[i].law.table;
        mu[i] = table ? table->largest : p->cam[i].friction * p->cam[i].law.peak;
    }
    if (!any_friction_depends_on_load(p)) return;
    double found[2] = {0.0, 0.0};
    for (Sampler s = sampler_of(p, transmission); next_sample(&s);) { /* at most JAM_SAMPLES turns per piece */
        Geometry g = cam_geometry(p->cam, s.point.slope);
        cam_set_load(p, spring_force(&p->spring, s.point.z) + F_ext, &g);
        for (int i = 0; i < 2; i++) found[i] = max_of(found[i], g.friction[i]);
    }
    for (int i = 0; i < 2; i++)
        if (!p->cam[i].law.table) mu[i] = found[i];
}

/* ---- classes ---- */

static bool is_positive_at_corners(const Params *p, const Transmission *transmission, const double mu[2],
                                   Resistance by) {
    for (int k = 0; k < FLANK_PAIR_COUNT; k++) {
        int sign[2];
        flank_pair(k, 1, sign);
        const Determinant d = {p, {sign[0] * mu[0], sign[1] * mu[1]}, by};
        if (!is_positive(&d, transmission)) return false;
    }
    return true;
}

FrictionClass domain_class(const Params *p, const Transmission *transmission, double F_ext) {
    double mu[2];
    largest_friction(p, transmission, F_ext, mu);
    /* Masses resist in both directions alike. */
    for (int direction = has_inertia(p) ? 1 : -1; direction <= 1; direction += 2)
        if (!is_positive_at_corners(p, transmission, mu, resistance_at_speed(p, direction)))
            return FRICTION_CLASS_SELF_LOCKING;
    return FRICTION_CLASS_UNIQUE;
}

/* ---- no torque loads the mechanism ---- */

/* Of a helix the parameter, as `cam1.lead_angle = 1.5`; of other grooves the lead angle at this slope. */
static void name_lead(char text[80], const Params *p, int i, double slope) {
    if (p->cam[i].profile == PROFILE_HELIX)
        snprintf(text, 80, "cam%d.lead_angle = %s", i + 1, shortest_decimal(p->cam[i].lead_angle).text);
    else
        snprintf(text, 80, "lead angle %s of cam%d there",
                 shortest_decimal(elementary_atan(slope / p->cam[i].radius)).text, i + 1);
}

static void name_friction(char text[128], const CamParams *cam, double mu, int i) {
    const FrictionParams *law = &cam->law;
    if (law->table) snprintf(text, 128, "cam%d.friction_table with mu up to %s", i + 1, shortest_decimal(mu).text);
    else if (law->load_exponent != 0.0)
        snprintf(text, 128, "cam%d.friction = %s, under load up to mu = %s", i + 1,
                 shortest_decimal(cam->friction).text, shortest_decimal(mu).text);
    else if (law->peak == 1.0) snprintf(text, 128, "cam%d.friction = %s", i + 1, shortest_decimal(cam->friction).text);
    else
        snprintf(text, 128, "cam%d.friction = %s times cam%d.friction_peak = %s at rest", i + 1,
                 shortest_decimal(cam->friction).text, i + 1, shortest_decimal(law->peak).text);
}

static void describe_jam(Fault *fault, const Params *p, const Sampler *at, const double mu[2]) {
    char lead[2][80], friction[2][128];
    for (int i = 0; i < 2; i++) {
        name_lead(lead[i], p, i, at->point.slope[i]); /* of a helix only the parameter is named */
        name_friction(friction[i], &p->cam[i], mu[i], i);
    }
    snprintf(fault->text, sizeof fault->text,
             "the contacts jam when loading at theta = %s: %s and %s with %s and %s; kappa_1 + kappa_2 must be > 0 "
             "from stop.lower to stop.upper, as with smaller lead angles or less friction",
             shortest_decimal(at->theta).text, lead[0], lead[1], friction[0], friction[1]);
}

bool domain_check_loading(const Params *p, const Transmission *transmission, double F_ext, Fault *fault) {
    double mu[2];
    largest_friction(p, transmission, F_ext, mu);
    const Determinant delta = {p, {mu[0], mu[1]}, {1.0, 0.0, 0.0}};
    if (is_positive(&delta, transmission)) return true;
    for (Sampler s = sampler_of(p, transmission); next_sample(&s);) { /* at most JAM_SAMPLES turns per piece */
        if (determinant_at(&delta, s.point.slope) > 0.0) continue;
        describe_jam(fault, p, &s, mu);
        return false;
    }
    return true;
}

/* ---- nothing resists ---- */

/* The pair of flanks that carries F > 0 on the edge of the band; its signed friction coefficients, at rest. */
static bool edge_friction(const Params *p, const Sampler *s, double F_ext, int direction, double f[2]) {
    Geometry g = cam_geometry(p->cam, s->point.slope);
    int flank[2];
    Transfer transfer;
    cam_set_load(p, spring_force(&p->spring, s->point.z) + F_ext, &g);
    if (!contact_edge(&g, direction, flank, &transfer) || !(transfer.delta > 0.0)) return false;
    for (int i = 0; i < 2; i++) f[i] = direction * flank[i] * g.friction[i];
    return true;
}

/* inertia.shaft, or without inertia shaft.damping, that makes D = 0: minus the rest of D over Delta. */
static double missing_at(const Determinant *d, const double slope[2]) {
    Determinant delta = *d, rest = *d;
    delta.by = (Resistance){1.0, 0.0, 0.0};
    rest.by.shaft = 0.0;
    return -determinant_at(&rest, slope) / determinant_at(&delta, slope);
}

bool domain_check_motion(const Params *p, const Transmission *transmission, double F_ext, Fault *fault) {
    /* D > 0 at the corners is D > 0 on every pair. A shaft without inertia of its own can still be level. */
    if (p->inertia.shaft > 0.0 && domain_class(p, transmission, F_ext) == FRICTION_CLASS_UNIQUE) return true;
    double most = 0.0, at = 0.0;
    int worst = 0;
    for (Sampler s = sampler_of(p, transmission); next_sample(&s);) { /* at most JAM_SAMPLES turns per piece */
        for (int direction = -1; direction <= 1; direction += 2) {
            Determinant d = {.params = p, .by = resistance_of(p, direction)};
            if (!edge_friction(p, &s, F_ext, direction, d.f)) continue;
            const double missing = missing_at(&d, s.point.slope);
            const bool outweighed = has_inertia(p) && missing >= d.by.shaft;
            const bool level = d.by.shaft == 0.0 && d.by.turning == 0.0 &&
                               cam_dz_dtheta(s.point.slope) <= NEAR_DWELL * transmission->slope_size;
            if (!(outweighed || level) || (worst != 0 && missing <= most)) continue;
            most = missing;
            at = s.theta;
            worst = direction;
        }
    }
    if (worst == 0) return true;
    snprintf(fault->text, sizeof fault->text, "nothing resists %s at theta = %s, where %s: %s must exceed %s",
             worst > 0 ? "loading" : "releasing", shortest_decimal(at).text,
             most > 0.0 ? "a contact locks and the follower outweighs the shaft" : "a groove is level",
             has_inertia(p) ? "inertia.shaft" : "shaft.damping", shortest_decimal(max_of(most, 0.0)).text);
    return false;
}
