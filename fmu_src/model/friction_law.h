/* The friction law: the one place that holds mu(v, R), the friction coefficient of a contact at the sliding speed v and
 * the reaction R of one contact.
 *
 *     mu(v, R) = mu_k [1 + (peak - 1) exp(-(v/v_s)^delta)] (R/R_ref)^nu + mu_v v      (docs/mechanism.md, section 9)
 *
 * mu_k: kinetic coefficient; peak: static over kinetic coefficient; v_s: Stribeck velocity; delta: 1 (Tustin) or 2
 * (Gauss); mu_v: slope of the lubricated branch (B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, Automatica 30,
 * 1994); nu: load exponent. With peak = 1, mu_v = 0 and nu = 0 the law is Coulomb's.
 *
 * Where the law does not depend on R, the functions without R hold. Where it does, they give mu at R_ref, and
 * friction_under() and friction_along() give mu at any R; contact/loaded_contacts.h finds mu and R together.
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
static inline bool friction_varies(const CamParams *cam) {
    return (cam->law.peak != 1.0 && cam->friction > 0.0) || cam->law.viscous > 0.0 || cam->law.table != NULL;
}

static inline bool any_friction_varies(const Params *p) {
    const FrictionParams *a = &p->cam[0].law, *b = &p->cam[1].law;
    const bool coulomb = a->peak + b->peak == 2.0 && a->viscous + b->viscous == 0.0; /* without a branch for each */
    return !(coulomb && !a->table && !b->table) && (friction_varies(&p->cam[0]) || friction_varies(&p->cam[1]));
}

/* Does the coefficient depend on the reaction? */
static inline bool friction_depends_on_load(const CamParams *cam) {
    if (cam->law.table) return cam->law.table->loads > 1;
    return cam->law.load_exponent != 0.0 && cam->friction > 0.0;
}

static inline bool any_friction_depends_on_load(const Params *p) {
    return friction_depends_on_load(&p->cam[0]) || friction_depends_on_load(&p->cam[1]);
}

/* mu(0+): the coefficient at rest, on the edge of the stick band, and where slip begins; at R_ref. */
static inline double friction_static(const CamParams *cam) {
    return cam->law.table ? cam->law.table->at_rest : cam->friction * cam->law.peak;
}

/* mu and its derivative; v in m/s. A negative v, at which an iteration may look, continues the law smoothly. */
FrictionCoefficient friction_at(const CamParams *cam, double v);

/* mu(v, R) and its derivatives; R >= 0 in N, of one contact. Below LEVEL_LOG_FROM R_ref the coefficient levels off:
 * with nu < 0 it would grow without bound. */
LoadedFriction friction_under(const CamParams *cam, double v, double R);

/* mu(0+, |R|) */
static inline double friction_at_rest(const CamParams *cam, double R) {
    return friction_depends_on_load(cam) ? friction_under(cam, 0.0, R < 0.0 ? -R : R).value : friction_static(cam);
}

/* The range of speeds in which mu falls steeply. A collocation step that spans more than a part of the range would step
 * over the fall unseen. A step also ends at the samples of a table. */
typedef struct {
    double end;  /* m/s, above which the law is smooth; -infinity: everywhere */
    double span; /* m/s, the change of speed in one step below the end */
    const FrictionTable *table;
    double overshoot; /* share of a piece of the table, or of the level */
    double level;     /* N, below which the law levels off: its fifth derivative jumps there; 0: no load law */
} FrictionFall;

/* The share, above 0 and at most 1, of a change of speed from v to `to` that one step may span. */
static inline double friction_share(const FrictionFall *fall, double v, double to) {
    if (fall->table) return friction_table_share(fall->table, fall->overshoot, v, to);
    if ((v < to ? v : to) >= fall->end) return 1.0;
    const double allowed = (v > fall->end ? v - fall->end : 0.0) + fall->span, change = v > to ? v - to : to - v;
    return allowed < change ? allowed / change : 1.0;
}

/* May one step span the speeds from `low` to `high`? The step starts at v. Not for tables. */
static inline bool friction_is_resolved(const FrictionFall *fall, double v, double low, double high) {
    if (low >= fall->end) return true;
    const double allowed = (v > fall->end ? v - fall->end : 0.0) + fall->span;
    return v - low <= allowed && (v >= fall->end || high - v <= allowed);
}

/* What both contacts have friction from: laws; tables with loads, at both contacts or at one; tables without loads. The
 * order counts: the last two need the pieces of a table, or a law, without loads. */
typedef enum { FRICTION_BY_LAWS, FRICTION_ON_PATCHES, FRICTION_ON_PATCH, FRICTION_ON_PIECES } FrictionSource;

/* The law of a contact as a step evaluates it again and again: its constants, in both halves of a vector. */
typedef struct {
    Vector2 kinetic, viscous;   /* mu_k; s/m, mu_v */
    Vector2 excess, minus_by_v; /* mu_k (peak - 1); s/m, -1/v_s */
    Vector2 per_load;           /* 1/N, 1/(n R_ref), or 1/(n R_1) of a table with loads */
    Vector2 load_exponent;      /* nu, 0 where the law does not depend on the load */
    Vector2 radius, radius2;    /* m, m^2: r and r^2 */
    double gone;                /* m/s, above which the excess is below all rounding */
    Vector2 sign;               /* of all values */
    bool is_gauss;              /* the Stribeck exponent is 2 */
    bool has_table;
    bool has_patches; /* the table has loads */
    FrictionSource source;
} FrictionNearby;

/* What the parameters of a contact imply for every step where friction varies. */
typedef struct {
    FrictionFall fall;
    FrictionNearby near[2]; /* by friction_sign_index() */
    /* The contact and its table, or of a contact without a table the other one and its table, or NULL: */
    int tabled;
    const FrictionTable *table;
    const FrictionTable *loaded; /* the table of this contact if it has more than one load, else NULL */
} FrictionConstants;

/* Of contact `i`, 0 or 1. */
void friction_prepare(const Params *params, int i, FrictionConstants *constants);

/* `sign`: sigma e_i, on all values of friction_nearby_at(). */
static inline int friction_sign_index(int sign) {
    return sign < 0;
}

/* mu and dmu/dv at two speeds v. */
typedef struct {
    Vector2 value, by_speed;
} VectorFriction;

/* Of a table, on its piece. An iteration may look a quarter of the piece beyond its ends. */
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

/* mu on two pieces of tables, at a speed on each. */
static inline Vector2 friction_on_pieces(const FrictionPiece *p, const FrictionPiece *q, Vector2 v) {
    const Vector2 lower = {p->cell.lower, q->cell.lower}, per_width = {p->per_width[0], q->per_width[0]};
    const Vector2 t = (v - lower) * per_width;
    Vector2 u = {p->c[4][0], q->c[4][0]};
    for (int n = 3; n >= 0; n--) u = u * t + (Vector2){p->c[n][0], q->c[n][0]};
    u *= t;
    return (Vector2){p->mu[0], q->mu[0]} * (p->is_flat && q->is_flat ? vector2_exp_small(u) : vector2_exp(u));
}

/* A factor that depends on the load, and its derivative by ln R. */
typedef struct {
    Vector2 value, by_log_load;
    bool is_power; /* by_log_load is nu q^nu */
} VectorLoadPower;

/* mu, dmu/dv, and the first and second derivative of ln mu by ln R */
typedef struct {
    Vector2 value, by_speed, power, bend;
} VectorLoadedFriction;

/* Both contacts at the start of a step on patches: mu, which by_speed lacks; b, its derivative by ln R, and how far up
 * and down (below 0) the patch goes on. */
typedef struct {
    VectorLoadedFriction mu;
    Vector2 log_mu, b, per, above, below;
} FrictionStart;

/* One contact there: what is near to it has logarithm and exponential by short series. R: N, of all contacts, 0 where
 * nothing counts as near. */
typedef struct {
    Vector2 R, b, log_mu, mu;
    Vector2 per_load; /* 1/N, 1/(n R_1) */
} FrictionNear;

/* Of tables on their patches, at a speed and a load of each contact; q = R/R_1 >= 0. */
void friction_start(const FrictionPatch *const patch[2], const FrictionPiece *const piece[2], const double v[2],
                    const double q[2], FrictionStart *start);

/* Of a table on its patch, at two speeds and two reactions R >= 0 of all contacts. by_speed only `with_slope`. */
VectorLoadedFriction friction_on_patch(const FrictionPatch *patch, const FrictionPiece *piece, const FrictionNear *near,
                                       Vector2 v, Vector2 R, bool with_slope);

/* friction_at() at two speeds, times the sign, to some roundings; the derivative by the speed only for speeds >= 0.
 * Without a table: */
static inline VectorFriction friction_by_law(const FrictionNearby *near, Vector2 v) {
    VectorFriction mu = {near->kinetic + near->viscous * v, near->viscous};
    if (v[0] > near->gone && v[1] > near->gone) return mu;
    const Vector2 ratio = v * near->minus_by_v;
    Vector2 exponent, slope = near->minus_by_v;
    if (near->is_gauss) {
        exponent = -ratio * ratio;
        slope *= -2.0 * ratio;
    } else {
        exponent = (Vector2){ratio[0] > 1.0 ? 1.0 : ratio[0], ratio[1] > 1.0 ? 1.0 : ratio[1]}; /* see Exponent */
    }
    const Vector2 share = near->excess * vector2_exp(exponent);
    mu.value += share;
    mu.by_speed += share * slope;
    return mu;
}

/* q^nu, as level_log() has the logarithm, and q times its derivative; q = R/R_ref >= 0. */
VectorLoadPower friction_load_power(Vector2 exponent, Vector2 q);

/* mu along a motion, as a Taylor polynomial in time, of cam `i` (0 or 1); its slopes are derivatives by `known`. `R` is
 * not used where the law does not depend on the load. */
Jet friction_along(const CamParams *cam, int i, const Jet *v, const Jet *R, Known known);

#endif
