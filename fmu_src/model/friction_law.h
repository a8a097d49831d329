/* The friction law: the one place that holds mu(v, N), the friction coefficient of a contact at the sliding speed v and
 * the nominal load N of one contact.
 *
 *     mu(v, N) = mu_k [1 + (peak - 1) exp(-(v/v_s)^delta)] ((N^2 + N_0^2)/N_ref^2)^(nu/2) + mu_v v
 *                                                                                  (docs/mechanism.md, section 9)
 * with N_0 = NOMINAL_LOAD_LOW N_ref. The nominal load is an explicit function of theta, omega and time, so that mu is
 * known before the balance of forces is solved.
 *
 * A table of samples (friction_table.h) replaces this law where the user names one.
 *
 * The law stands here once for each arithmetic, as the formulas of contact/contact_factors.h do. Another law replaces
 * the functions of this header, and nothing else. */
#ifndef DUALCAM_FRICTION_LAW_H
#define DUALCAM_FRICTION_LAW_H

#include "elementary/vector2.h"
#include "model/friction_table.h"
#include "model/known.h"
#include "model/params.h"
#include "numerics/jet.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

/* Does the coefficient depend on the sliding speed? */
static inline bool friction_depends_on_speed(const CamParams *cam) {
    return (cam->law.peak != 1.0 && cam->friction > 0.0) || cam->law.viscous > 0.0 || cam->law.table != NULL;
}

/* Does the coefficient depend on the nominal load? */
static inline bool friction_depends_on_load(const CamParams *cam) {
    if (cam->law.table) return cam->law.table->loads > 1;
    return cam->law.load_exponent != 0.0 && cam->friction > 0.0;
}

static inline bool any_friction_depends_on_speed(const Params *p) {
    return friction_depends_on_speed(&p->cam[0]) || friction_depends_on_speed(&p->cam[1]);
}

static inline bool any_friction_depends_on_load(const Params *p) {
    return friction_depends_on_load(&p->cam[0]) || friction_depends_on_load(&p->cam[1]);
}

/* False for Coulomb's law at both contacts, without a branch for each member. */
static inline bool any_friction_varies(const Params *p) {
    const FrictionParams *a = &p->cam[0].law, *b = &p->cam[1].law;
    const bool coulomb = a->peak + b->peak == 2.0 && a->viscous + b->viscous == 0.0 &&
                         fabs(a->load_exponent) + fabs(b->load_exponent) == 0.0;
    return !(coulomb && !a->table && !b->table) &&
           (any_friction_depends_on_speed(p) || any_friction_depends_on_load(p));
}

/* mu and its derivatives at v, m/s, and N >= 0, N, of one contact. A negative v, at which an iteration may look,
 * continues the law smoothly. */
FrictionCoefficient friction_at(const CamParams *cam, double v, double N);

/* mu(0+, N): on the edge of the stick band, and where slip begins. */
static inline double friction_at_rest(const CamParams *cam, double N) {
    if (!friction_depends_on_load(cam)) return cam->law.table ? cam->law.table->at_rest : cam->friction * cam->law.peak;
    return friction_at(cam, 0.0, N).value;
}

/* The range of speeds in which mu falls steeply. A collocation step that spans more than a part of the range would step
 * over the fall unseen. A step also ends at the samples of a table. */
typedef struct {
    double end;  /* m/s, above which the law is smooth; -infinity: everywhere */
    double span; /* m/s, the change of speed in one step below the end */
    const FrictionTable *table;
    double overshoot; /* share of a piece of the table */
    double low;       /* N, around which a law of the load bends: NOMINAL_LOAD_LOW N_ref; 0: no such law */
} FrictionFall;

/* The share, above 0 and at most 1, of a change of speed from v to `to` that one step may span. */
static inline double friction_share(const FrictionFall *fall, double v, double to) {
    if (fall->table) return friction_table_share(fall->table, fall->overshoot, v, to);
    if ((v < to ? v : to) >= fall->end) return 1.0;
    const double allowed = (v > fall->end ? v - fall->end : 0.0) + fall->span, change = v > to ? v - to : to - v;
    return allowed < change ? allowed / change : 1.0;
}

/* The share, above 0 and at most 1, of a change of the load, N, signed as F, that one step may span: near load zero the
 * law has a bend as wide as `low`, which the nodes of a longer step would not see. */
static inline double friction_load_share(const FrictionFall *fall, double from, double to) {
    if (fall->low == 0.0) return 1.0;
    const double nearest = from * to <= 0.0 ? 0.0 : min_of(fabs(from), fabs(to)), change = fabs(to - from);
    const double allowed = NOMINAL_LOAD_SPAN * (nearest + fall->low);
    return allowed < change ? allowed / change : 1.0;
}

/* May one step span the speeds from `low` to `high`? The step starts at v. Not for tables. */
static inline bool friction_is_resolved(const FrictionFall *fall, double v, double low, double high) {
    if (low >= fall->end) return true;
    const double allowed = (v > fall->end ? v - fall->end : 0.0) + fall->span;
    return v - low <= allowed && (v >= fall->end || high - v <= allowed);
}

/* The law of a contact as a step evaluates it again and again: its constants, in both halves of a vector. */
typedef struct {
    Vector2 kinetic, viscous;   /* mu_k; s/m, mu_v */
    Vector2 excess, minus_by_v; /* mu_k (peak - 1); s/m, -1/v_s */
    Vector2 per_load2;          /* 1/(n r N_ref)^2 times (F sliding)^2 is (N/N_ref)^2; of a table with N_ref = 1 N */
    Vector2 half_exponent;      /* nu/2, 0 where the law does not depend on the load */
    Vector2 binomial[6];        /* of (1 + u)^(nu/2): the coefficients of u, ..., u^6 */
    Vector2 radius, radius2;    /* m, m^2: r and r^2 */
    double gone;                /* m/s, above which the excess is below all rounding */
    Vector2 sign;               /* of all values */
    bool is_gauss;              /* the Stribeck exponent is 2 */
    bool has_table;
} FrictionNearby;

/* What the parameters of a contact imply for every step where friction varies. */
typedef struct {
    FrictionFall fall;
    FrictionNearby near[2]; /* by friction_sign_index() */
    /* The contact and its table, or of a contact without a table the other one and its table, or NULL: */
    int tabled;
    const FrictionTable *table;
} FrictionConstants;

/* Of contact `i`, 0 or 1. */
void friction_prepare(const Params *params, int i, FrictionConstants *constants);

/* `sign`: sigma e_i, on all values of friction_by_law(). */
static inline int friction_sign_index(int sign) {
    return sign < 0;
}

/* mu and dmu/dv at two speeds v. */
typedef struct {
    Vector2 value, by_speed;
} VectorFriction;

/* Of a table with one load, on its piece. An iteration may look a quarter of the piece beyond its ends. */
ALWAYS_INLINE static inline VectorFriction friction_on_piece(Vector2 sign, const FrictionPiece *p, Vector2 v) {
    Vector2 t = (v - p->lower) * p->per_width, slope = p->c[4], u = slope;
    t = vector2_min(vector2_max(t, (Vector2){-0.25, -0.25}), (Vector2){1.25, 1.25});
    for (int n = 3; n >= 0; n--) {
        u = u * t + p->c[n];
        slope = slope * t + u;
    }
    u *= t;
    const Vector2 mu = (sign * p->mu) * (p->is_flat ? vector2_exp_small(u) : vector2_exp(u));
    return (VectorFriction){mu, mu * slope * p->per_width};
}

/* Of a table with loads, on its patch; load2: N^2. */
VectorFriction friction_on_patch(Vector2 sign, const FrictionPatch *patch, const FrictionPiece *piece, Vector2 v,
                                 Vector2 load2);

/* ((N^2 + N_0^2)/N_ref^2)^(nu/2), load2: (N/N_ref)^2. */
static inline Vector2 friction_load_power(Vector2 half_exponent, Vector2 load2) {
    return vector2_exp(half_exponent * vector2_log(load2 + NOMINAL_LOAD_LOW * NOMINAL_LOAD_LOW));
}

/* This power at the start of a step. */
typedef struct {
    Vector2 load2, per; /* (N/N_ref)^2, and 1/(load2 + (N_0/N_ref)^2) */
    Vector2 power;
} FrictionLoadStart;

/* The same, where the load is near to that at the start by the binomial series. */
static inline Vector2 friction_load_power_near(const FrictionNearby *near, const FrictionLoadStart *start,
                                               Vector2 load2) {
    const Vector2 u = (load2 - start->load2) * start->per;
    if (!vector2_is_within(u, LOAD_POWER_NEAR)) return friction_load_power(near->half_exponent, load2);
    const Vector2 *c = near->binomial;
    return start->power * (1.0 + u * (c[0] + u * (c[1] + u * (c[2] + u * (c[3] + u * (c[4] + u * c[5]))))));
}

/* Without a table: friction_at() at two speeds, times the sign, to some roundings; the derivative by the speed only for
 * speeds >= 0. start: of the load power; load2: (N/N_ref)^2. */
static inline VectorFriction friction_by_law(const FrictionNearby *near, const FrictionLoadStart *start, Vector2 v,
                                             Vector2 load2) {
    VectorFriction dry = {near->kinetic, {0.0, 0.0}};
    if (!(v[0] > near->gone && v[1] > near->gone)) {
        const Vector2 ratio = v * near->minus_by_v;
        Vector2 exponent, slope = near->minus_by_v;
        if (near->is_gauss) {
            exponent = -ratio * ratio;
            slope *= -2.0 * ratio;
        } else {
            exponent = (Vector2){ratio[0] > 1.0 ? 1.0 : ratio[0], ratio[1] > 1.0 ? 1.0 : ratio[1]}; /* see Exponent */
        }
        const Vector2 share = near->excess * vector2_exp(exponent);
        dry.value += share;
        dry.by_speed = share * slope;
    }
    if (near->half_exponent[0] != 0.0) {
        const Vector2 power = friction_load_power_near(near, start, load2);
        dry.value *= power;
        dry.by_speed *= power;
    }
    return (VectorFriction){dry.value + near->viscous * v, dry.by_speed + near->viscous};
}

/* mu along a motion, as a Taylor polynomial in time, of cam `i` (0 or 1); its slopes are derivatives by `known`. load2:
 * N^2 of one contact. */
Jet friction_along(const CamParams *cam, int i, const Jet *v, const Jet *load2, Known known);

#endif
