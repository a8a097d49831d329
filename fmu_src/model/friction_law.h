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

#include "model/friction_table.h"
#include "model/known.h"
#include "model/params.h"
#include "numerics/jet.h"
#include "numerics/tolerances.h"
#include "numerics/vector2.h"

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

/* The samples over the load end steps, as those over the speed do. */
static inline bool any_friction_table_has_loads(const Params *p) {
    const FrictionTable *a = p->cam[0].law.table, *b = p->cam[1].law.table;
    return (a && a->loads > 1) || (b && b->loads > 1);
}

/* mu(0+): the coefficient at rest, on the edge of the stick band, and where slip begins; at R_ref. */
static inline double friction_static(const CamParams *cam) {
    return cam->law.table ? friction_table_at_rest(cam->law.table) : cam->friction * cam->law.peak;
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
    double overshoot; /* share of a piece of the table */
} FrictionFall;

/* `tolerance`: relative, of the motion. */
FrictionFall friction_fall(const CamParams *cam, double tolerance);

/* The share, above 0 and at most 1, of a change of speed from v to `to` that one step may span. */
static inline double friction_share(const FrictionFall *fall, double v, double to) {
    if (fall->table) return friction_table_share(fall->table, fall->overshoot, v, to);
    if ((v < to ? v : to) >= fall->end) return 1.0;
    const double allowed = (v > fall->end ? v - fall->end : 0.0) + fall->span, change = v > to ? v - to : to - v;
    return allowed < change ? allowed / change : 1.0;
}

/* The law at one speed, and what the law at speeds nearby shares with it. */
typedef struct {
    double value;     /* mu(v) */
    double excess;    /* mu_k (peak - 1) */
    double per_speed; /* s/m, 1/v_s; 0 without an excess */
} FrictionBase;

FrictionBase friction_base(const CamParams *cam, double v);

/* mu and dmu/dv at two speeds v. */
typedef struct {
    Vector2 value, by_speed;
} VectorFriction;

VectorFriction friction_table_at_both(const FrictionTable *table, Vector2 v);

/* friction_at() at two speeds, to some roundings. */
static inline VectorFriction friction_near(const CamParams *cam, const FrictionBase *base, Vector2 v) {
    if (cam->law.table) return friction_table_at_both(cam->law.table, v);
    const Vector2 ratio = v * base->per_speed, none = {0.0, 0.0};
    const bool gauss = cam->law.stribeck_exponent == 2;
    const double from = gauss ? -INFINITY : -1.0; /* see stribeck_exponent() */
    const Vector2 inside = {ratio[0] < from ? from : ratio[0], ratio[1] < from ? from : ratio[1]};
    const Vector2 exponent = gauss ? -ratio * ratio : -inside;
    if (base->excess == 0.0 || fmax(exponent[0], exponent[1]) < STRIBECK_GONE)
        return (VectorFriction){cam->friction + cam->law.viscous * v, none + cam->law.viscous};
    const Vector2 share = base->excess * vector2_exp(exponent);
    const Vector2 tustin = {ratio[0] > from ? -1.0 : 0.0, ratio[1] > from ? -1.0 : 0.0};
    const Vector2 slope = gauss ? none - 2.0 * ratio : tustin;
    return (VectorFriction){cam->friction + cam->law.viscous * v + share,
                            cam->law.viscous + share * slope * base->per_speed};
}

/* (R/R_ref)^nu at two reactions R >= 0 of one contact, as level_log.h has the logarithm, and R times its derivative. */
typedef struct {
    Vector2 value, by_log_load;
} VectorLoadPower;

VectorLoadPower friction_load_power(const CamParams *cam, Vector2 R);

/* mu along a motion, as a Taylor polynomial in time, of cam `i` (0 or 1); its slopes are derivatives by `known`. `R` is
 * not used where the law does not depend on the load. */
Jet friction_along(const CamParams *cam, int i, const Jet *v, const Jet *R, Known known);

#endif
