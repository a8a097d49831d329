#include "collocation/radau_variation.h"

#include <math.h>

#include "collocation/radau_system.h"
#include "numerics/lu.h"
#include "numerics/tolerances.h"
#include "platform/attributes.h"

COMPACT_BEGIN

/* The collocation equations, differentiated: with y_j the change of alpha (or omega) at node j,
 *     y_i = by_theta_i dtheta_i + by_omega_i domega_i + mobility_i torque
 * where dtheta_i and domega_i follow from y as theta_i and omega_i do. A pole at the end is left out. Such a pole
 * belongs to an angle that is a root of time, see vary_in_parts(). */
COLD static bool vary(const SlipMode *slip, const RadauStep *step, double torque, Variation *v) {
    const Radau *r = step->method;
    const RadauSystem s = {.slip = slip, .method = r, .h = step->h};
    const int n = r->stages;
    const bool inertial = slip->regime == REGIME_INERTIAL;
    const double omega = inertial ? v->omega : 0.0;
    Lu lu = {.n = n};
    double y[RADAU_MAX], twice = 0.0, before = INFINITY;
    for (int i = 0; i < n; i++) {
        RightHandSide p = step->node[i].rhs;
        double mobility = balance_mobility(slip, &step->node[i]);
        if (!(fabs(mobility) <= VARIATION_POLE * before)) mobility = p.by_theta = 0.0;
        before = fabs(mobility);
        radau_system_newton_row(&s, &p, i, lu.a[i]);
        y[i] = p.by_theta * (v->theta + r->node[i] * s.h * omega) + p.by_omega * omega + mobility * torque;
    }
    if (!lu_factorize(&lu)) return false;
    lu_solve(&lu, y);
    const double once = s.h * radau_dot(r->weight, y, n);
    for (int j = 0; j < n; j++) twice += s.h * s.h * r->twice[j][n - 1] * y[j];
    v->theta += inertial ? s.h * omega + twice : once;
    v->omega = inertial ? omega + once : y[n - 1];
    return true;
}

/* How far the variation has been carried through a step. */
typedef struct {
    Inputs inputs;
    Balance at;
    Variation v;
} VariationFront;

/* Carries the variation on by t seconds in one step. */
COLD static bool carry(const SlipMode *slip, double t, double torque, VariationFront *front) {
    RadauStep step;
    SlipMode here = *slip;
    here.inputs = &front->inputs;
    here.to_rounding = true;
    if (!radau_step_solve(&here, &front->at, t, RADAU_MAX, &step) || !vary(&here, &step, torque, &front->v))
        return false;
    inputs_advance(&front->inputs, t);
    balance_at(&here, front->at.theta + step.dtheta, 0.0, 0.0, &front->at);
    return true;
}

/* The same part in one step, and in two steps of half its length. */
typedef struct {
    VariationFront once, twice;
} PartTwice;

COLD static bool carry_twice(const SlipMode *slip, double t, double torque, PartTwice *part) {
    bool found = true;
    for (int k = 0; found && k < 3; k++)
        found = carry(slip, k == 0 ? t : 0.5 * t, torque, k == 0 ? &part->once : &part->twice);
    return found && isfinite(part->once.v.theta + part->twice.v.theta);
}

/* Without inertia a step that is good for the motion may be too long for its variation: a variation that dies out
 * while the motion is steady, or, where quadratic damping alone acts, a speed that is a root of time. So the step is
 * gone through again in parts. A part is accepted if one step and two half steps agree. It is accepted too if it is
 * short against the times from the start and to the end of the step: only rounding can differ there. The shortest
 * parts lie next to the start and the end, where the error is proportional to the root of the length: one step and two
 * half steps together then give the limit (Richardson's extrapolation). */
COLD static bool vary_in_parts(const SlipMode *slip, const RadauStep *step, double torque, Variation *v) {
    static const double ROOT = 3.414213562373095; /* 1/(1 - sqrt(1/2)) */
    VariationFront front = {.at = step->start, .v = *v};
    front.inputs = *slip->inputs;
    const double h = step->h;
    double left = h, t = h, scale = fabs(v->theta);
    for (int n = 0; n < VARIATION_TRIALS && left > 0.0 && t > 0.1 * VARIATION_SHORTEST * h; n++) {
        PartTwice part = {front, front};
        t = fmin(t, left);
        const bool is_shortest = t <= VARIATION_SHORTEST * h;
        const bool is_short = is_shortest || t <= VARIATION_SHORT * fmin(h - left, left);
        const bool found = carry_twice(slip, t, torque, &part);
        const double once = part.once.v.theta, twice = part.twice.v.theta;
        if (found) scale = fmax(scale, fabs(twice));
        if (found && (is_short || fabs(once - twice) <= VARIATION_TOLERANCE * scale)) {
            front = part.twice;
            if (is_shortest) front.v.theta = once + ROOT * (twice - once);
            left -= t;
            t *= 4.0;
        } else {
            t *= 0.25;
        }
    }
    *v = front.v;
    return true;
}

COLD bool radau_step_vary(const SlipMode *slip, const RadauStep *step, double torque, Variation *v) {
    return slip->regime == REGIME_INERTIAL ? vary(slip, step, torque, v) : vary_in_parts(slip, step, torque, v);
}

COMPACT_END
