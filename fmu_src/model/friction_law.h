/* The friction law: the one place that holds mu(v), the friction coefficient of a contact at the sliding speed v.
 *
 *     mu(v) = mu_k [1 + (peak - 1) exp(-(v/v_s)^delta)] + mu_v v        (docs/mechanism.md, section 9)
 *
 * mu_k: kinetic coefficient; peak: static over kinetic coefficient; v_s: Stribeck velocity; delta: 1 (Tustin) or 2
 * (Gauss); mu_v: slope of the lubricated branch (B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, Automatica 30,
 * 1994). With peak = 1 and mu_v = 0 the law is Coulomb's.
 *
 * The law stands here once for each arithmetic, as the formulas of contact/contact_factors.h do. Another law replaces
 * the functions of this header, and nothing else. */
#ifndef DUALCAM_FRICTION_LAW_H
#define DUALCAM_FRICTION_LAW_H

#include "model/known.h"
#include "model/params.h"
#include "numerics/jet.h"

/* Does the coefficient change while the pin slides? Else the law is Coulomb's. */
static inline bool friction_varies(const CamParams *cam) {
    return (cam->law.peak != 1.0 && cam->friction > 0.0) || cam->law.viscous > 0.0;
}

static inline bool any_friction_varies(const Params *p) {
    return friction_varies(&p->cam[0]) || friction_varies(&p->cam[1]);
}

/* mu(0+): the coefficient at rest, on the edge of the stick band, and where slip begins. */
static inline double friction_static(const CamParams *cam) {
    return cam->friction * cam->law.peak;
}

typedef struct {
    double value;
    double by_speed; /* s/m, dmu/dv */
} FrictionCoefficient;

/* mu and its derivative; v in m/s. A negative v, at which an iteration may look, continues the law smoothly. */
FrictionCoefficient friction_at(const CamParams *cam, double v);

/* The range of speeds in which mu falls steeply. A collocation step that spans more than a part of the range would step
 * over the fall unseen. */
typedef struct {
    double end;  /* m/s, above which the law is smooth; -infinity: everywhere */
    double span; /* m/s, the change of speed in one step below the end */
} FrictionFall;

/* `negligible`: the share of the fall that does not matter. */
FrictionFall friction_fall(const CamParams *cam, double negligible);

/* The share, above 0 and at most 1, of a change of speed from v to `to` that one step may span. */
static inline double friction_share(const FrictionFall *fall, double v, double to) {
    if ((v < to ? v : to) >= fall->end) return 1.0;
    const double allowed = (v > fall->end ? v - fall->end : 0.0) + fall->span, change = v > to ? v - to : to - v;
    return allowed < change ? allowed / change : 1.0;
}

/* mu along a motion, as a Taylor polynomial in time, of cam `i` (0 or 1); its slopes are derivatives by `known`. */
Jet friction_along(const CamParams *cam, int i, const Jet *v, Known known);

#endif
